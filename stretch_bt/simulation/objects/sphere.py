"""A sphere, fixed where it stands, that keeps its shape and gives way as a whole."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from stretch_bt.simulation.objects.base import HertzForm, Rough
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Length, Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["SphereObject"]


class SphereObject(SolidSpec):
    """A sphere, fixed where it stands."""

    type: Literal["sphere"]
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

    def rough(self) -> Rough:
        """Return its radius and stiffness."""
        return Rough(self.diameter / 2, self.roughly, edge=self.diameter / 2)

    def known(self) -> dict[str, float]:
        """Return its radius, m, and its stiffness, N/m."""
        return {"radius": self.diameter / 2, **super().known()}
