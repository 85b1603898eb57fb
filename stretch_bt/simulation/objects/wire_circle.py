"""A wire bent to a circle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.wire import WireSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.ring import Ring

__all__ = ["WireCircle"]


class WireCircle(WireSpec):
    """A wire bent to a circle that lies flat."""

    type: Literal["wire_circle"]
    diameter: Annotated[Length, Within(0.002, 0.3, "Length")] = Field(description="outer diameter of the circle")

    @model_validator(mode="after")
    def _hole(self) -> WireCircle:
        if self.diameter <= 2 * self.thickness:
            raise InvalidInput("the circle has no hole; write a larger diameter or a thinner wire")
        return self

    @property
    def around(self) -> float:
        """Length of the wire, m."""
        return math.pi * (self.diameter - self.thickness)

    @property
    def reach(self) -> float:
        """Its outer radius, m."""
        return self.diameter / 2

    def body(self) -> Ring:
        """Return a torus."""
        from stretch_bt.simulation.membrane.indenters.ring import Ring

        return Ring(self.thickness, self.diameter - self.thickness)

    def known(self) -> dict[str, float]:
        """Return its length and width, its height and its radius, m."""
        d = self.diameter
        return {"length": d, "width": d, "height": self.thickness, "radius": d / 2}
