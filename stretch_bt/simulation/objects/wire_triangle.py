"""A wire bent to a triangle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.wire import WireSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.wire_polygon import WirePolygon

__all__ = ["WireTriangle"]


class WireTriangle(WireSpec):
    """A wire bent to a triangle of equal sides that lies flat, one corner towards -y, its middle on the axis."""

    type: Literal["wire_triangle"]
    side: Annotated[Length, Within(0.003, 0.3, "Length")] = Field(
        description="side along the middle of the wire, as if its corners were sharp"
    )
    bend: Annotated[Length, Within(0.0, 0.1, "Length")] = Field(
        default=0.003, description="radius of its corners, along the middle of the wire"
    )

    @model_validator(mode="after")
    def _hole(self) -> WireTriangle:
        if self.side / (2 * math.sqrt(3)) <= self.bend + 2 * self.thickness:
            raise InvalidInput("the triangle has no hole or no straight sides; write a longer side, or a smaller bend")
        return self

    @property
    def around(self) -> float:
        """Length of the wire, m."""
        return 3 * self.side - 2 * self.bend * (3 * math.sqrt(3) - math.pi)

    @property
    def reach(self) -> float:
        """How far its corners are from its middle, m."""
        return self.side / math.sqrt(3) - self.bend + self.thickness / 2

    def body(self) -> WirePolygon:
        """Return three straight wires."""
        from stretch_bt.simulation.membrane.indenters.wire_polygon import WirePolygon

        return WirePolygon(self.thickness, self.side, bend=self.bend)

    def known(self) -> dict[str, float]:
        """Return its length along x and width along y, outside, its height and its side, m."""
        length = self.side - 2 * (math.sqrt(3) - 1) * self.bend + self.thickness
        width = self.side * math.sqrt(3) / 2 - self.bend + self.thickness
        return {"length": length, "width": width, "height": self.thickness, "side": self.side}
