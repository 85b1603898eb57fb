"""The common part of spheres: shape and size."""

from __future__ import annotations

from abc import ABC
from typing import TYPE_CHECKING, Annotated

from stretch_bt.simulation.objects.base import HertzForm, ObjectSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["RoundSpec"]


class RoundSpec(ObjectSpec, ABC):
    """Options of a sphere that stands on its lowest point."""

    diameter: Annotated[Length, Within(0.005, 0.080, "Length")]

    @property
    def top(self) -> float:
        """World height of its top, m."""
        return self.base + self.diameter

    @property
    def reach(self) -> float:
        """Its radius, m."""
        return self.diameter / 2

    @property
    def hertz(self) -> HertzForm:
        """A sphere."""
        return HertzForm("sphere", self.diameter / 2)

    def body(self) -> Sphere:
        """Return a hemisphere on a shank."""
        from stretch_bt.simulation.membrane.indenters.sphere import Sphere

        return Sphere(self.diameter)
