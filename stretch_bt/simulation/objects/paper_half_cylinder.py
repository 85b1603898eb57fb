"""A half-cylinder folded from paper."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stretch_bt.simulation.objects.base import Rough
from stretch_bt.simulation.objects.half_cylinder import crest, crest_aspect
from stretch_bt.simulation.objects.paper import PaperSpec, Walls
from stretch_bt.simulation.objects.roof import RoofResponse
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder

__all__ = ["PaperHalfCylinder"]

# w E t / F of a cylinder of R / t = 100 as long as wide, pinched at its middle between end walls (Belytschko and others,
# Comput. Methods Appl. Mech. Eng. 51:221, 1985)
_PINCHED, _SLENDER = 164.2, 100.0


class PaperHalfCylinder(PaperSpec):
    """A half-cylinder folded from paper, its axis along x: a vault between two end walls, open below."""

    type: Literal["paper_half_cylinder"]
    diameter: Annotated[Length, Within(0.01, 0.2, "Length")]
    length: Annotated[Length, Within(0.01, 0.2, "Length")] = Field(description="length along x")

    @property
    def top(self) -> float:
        """World height of its crest, m."""
        return self.base + self.diameter / 2

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return math.hypot(self.length, self.diameter) / 2

    @property
    def walls(self) -> Walls:
        """The two end walls, as rectangles around them."""
        return Walls(2, self.diameter, self.diameter / 2)

    @property
    def face(self) -> float:
        """Radius of the disc that its crest is like, m."""
        return crest(self.length, self.diameter)

    @property
    def area(self) -> float:
        """Area of vault and end walls, m^2."""
        return math.pi * self.diameter / 2 * self.length + math.pi * self.diameter**2 / 4

    def roof(self, share: float) -> RoofResponse:
        """Return the sag of its crest between the end walls: a pinched cylinder's, which goes as (R / t)^1.5."""
        slender = (self.diameter / 2 / self.thickness / _SLENDER) ** 1.5
        return RoofResponse(self.modulus * self.thickness / (_PINCHED * slender) / share)

    def body(self) -> HalfCylinder:
        """Return a half-cylinder on a shank."""
        from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder

        return HalfCylinder(self.diameter, self.length, self.edge)

    def rough(self) -> Rough:
        """Return the rough numbers of paper, with its round crest."""
        aspect = crest_aspect(self.length, self.diameter, self.heading)
        return replace(super().rough(), holds="crest", aspect=aspect)

    def known(self) -> dict[str, float]:
        """Return its length, width, height and radius, m."""
        r = self.diameter / 2
        return {"length": self.length, "width": self.diameter, "height": r, "radius": r}
