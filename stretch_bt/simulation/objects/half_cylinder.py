"""A half-cylinder that lies on its flat side."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stretch_bt.simulation.objects.base import Rough, turned_aspect
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder

__all__ = ["HalfCylinderObject", "crest", "crest_aspect"]

_HELD = math.sqrt(0.5)  # of its diameter: width of the crest, out to where the flank is at 45 degrees


def crest(length: float, diameter: float) -> float:
    """Return the radius, m, of the disc that lifts a membrane as a pressed crest does.

    The crest meets it in about an ellipse, of half the length and out to where the flank is at 45 degrees, whose logarithmic capacity is
    the mean of its half axes (Polya and Szego, Isoperimetric Inequalities in Mathematical Physics, 1951).
    """
    return (length + _HELD * diameter) / 4


def crest_aspect(length: float, diameter: float, heading: float) -> float:
    """Return the extent of that contact towards the clamps over the one across, at a heading, rad."""
    return turned_aspect(length, _HELD * diameter, heading)


class HalfCylinderObject(SolidSpec):
    """A half-cylinder that lies on its flat side, its axis along x."""

    type: Literal["half_cylinder"]
    diameter: Annotated[Length, Within(0.005, 0.3, "Length")]
    length: Annotated[Length, Within(0.005, 0.3, "Length")] = Field(description="length along x")
    edge: Annotated[Length, Within(0.0001, 0.010, "Length")] = Field(
        default=0.001, description="radius of the edges of its ends"
    )

    @property
    def top(self) -> float:
        """World height of its crest, m."""
        return self.base + self.diameter / 2

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return math.hypot(self.length, self.diameter) / 2

    def body(self) -> HalfCylinder:
        """Return a half-cylinder on a shank."""
        from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder

        return HalfCylinder(self.diameter, self.length, self.edge)

    def rough(self) -> Rough:
        """Return its radius, its stiffness and the disc that its crest is like."""
        face = crest(self.length, self.diameter)
        aspect = crest_aspect(self.length, self.diameter, self.heading)
        return Rough(self.diameter / 2, self.roughly, edge=self.edge, face=face, holds="crest", aspect=aspect)

    def known(self) -> dict[str, float]:
        """Return its length, width, height and radius, m, and its stiffness, N/m."""
        r = self.diameter / 2
        return {"length": self.length, "width": self.diameter, "height": r, "radius": r, **super().known()}
