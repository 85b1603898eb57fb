"""An upright cone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.base import Rough
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Angle, Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.cone import Cone

__all__ = ["ConeObject"]

_FLANK = 0.002  # m, in a press of 10 mm on a cone of 45 degrees


class ConeObject(SolidSpec):
    """An upright cone whose surface makes `angle` with the table."""

    type: Literal["cone"]
    angle: Annotated[Angle, Within(0.05, 1.5, "Angle")] = Field(description="angle between its surface and the table")
    height: Annotated[Length, Within(0.001, 0.5, "Length")] = Field(description="height of rounded tip above the foot")
    tip: Annotated[Length, Within(0.0001, 0.010, "Length")] = Field(default=0.0005, description="radius of its tip")

    @model_validator(mode="after")
    def _foot(self) -> ConeObject:
        if self.height <= self.tip * (1 - math.cos(self.angle)):
            raise InvalidInput("the cone is no higher than the cap of its tip; write a smaller tip")
        return self

    @property
    def top(self) -> float:
        """World height of its tip, m."""
        return self.base + self.height

    @property
    def reach(self) -> float:
        """Radius of its foot, m; the rounding cuts off the part that would be above the tip."""
        return (self.height + self.tip * (1 / math.cos(self.angle) - 1)) / math.tan(self.angle)

    def body(self) -> Cone:
        """Return a cone that goes on downwards."""
        from stretch_bt.simulation.membrane.indenters.cone import Cone

        return Cone(self.angle, self.tip)

    def rough(self) -> Rough:
        """Return the radius of its tip, at least that to which the sheet lies on its flank, and its stiffness."""
        return Rough(max(self.tip, _FLANK), self.roughly, edge=self.tip, holds="point", steep=math.tan(self.angle))

    def known(self) -> dict[str, float]:
        """Return its height, m, and its stiffness, N/m."""
        return {"height": self.height, **super().known()}
