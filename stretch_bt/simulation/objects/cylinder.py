"""An upright cylinder with a flat end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.base import HertzForm, Rough
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

__all__ = ["CylinderObject"]


class CylinderObject(SolidSpec):
    """An upright cylinder with a flat end."""

    type: Literal["cylinder"]
    diameter: Annotated[Length, Within(0.005, 0.080, "Length")]
    height: Annotated[Length, Within(0.001, 0.5, "Length")]
    rim: Annotated[Length, Within(0.0001, 0.040, "Length")] = Field(default=0.001, description="radius of its edge")

    @model_validator(mode="after")
    def _rim_fits(self) -> CylinderObject:
        if self.rim > self.diameter / 2:
            raise InvalidInput("the radius of its edge is at most half the diameter; write a smaller 'rim'")
        return self

    @property
    def top(self) -> float:
        """World height of its end, m."""
        return self.base + self.height

    @property
    def reach(self) -> float:
        """Its radius, m."""
        return self.diameter / 2

    @property
    def hertz(self) -> HertzForm:
        """A flat-ended cylinder."""
        return HertzForm("cylinder", self.diameter / 2)

    def body(self) -> Cylinder:
        """Return a flat-ended cylinder."""
        from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

        return Cylinder(self.diameter, self.rim)

    def rough(self) -> Rough:
        """Return its radius and stiffness."""
        return Rough(self.diameter / 2, self.roughly, edge=self.rim, face=self.diameter / 2, holds="rim")

    def known(self) -> dict[str, float]:
        """Return its radius, m, and its stiffness, N/m."""
        return {"radius": self.diameter / 2, **super().known()}
