"""A pyramid on a square."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stretch_bt.simulation.objects.base import Rough
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron

__all__ = ["PyramidObject", "blunt"]


def blunt(width: float, height: float, edge: float) -> float:
    """Return the height of a pyramid's sharp point over the rounded one, m: `edge` over its faces' cosine, less it."""
    return edge * (math.hypot(1.0, 2 * height / width) - 1)


class PyramidObject(SolidSpec):
    """A pyramid on a square."""

    type: Literal["pyramid"]
    width: Annotated[Length, Within(0.005, 0.3, "Length")] = Field(description="side of its square")
    height: Annotated[Length, Within(0.003, 0.3, "Length")] = Field(description="height of its point, edges sharp")
    edge: Annotated[Length, Within(0.0002, 0.010, "Length")] = Field(default=0.001, description="radius of its edges")

    @property
    def top(self) -> float:
        """World height of its rounded point, m."""
        return self.base + self.height - blunt(self.width, self.height, self.edge)

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return self.width / math.sqrt(2)

    def body(self) -> Polyhedron:
        """Return a pyramid with rounded edges."""
        from stretch_bt.simulation.membrane.indenters.shapes import pyramid

        return pyramid(self.width, self.height, self.edge)

    def rough(self) -> Rough:
        """Return the radius of its point and its stiffness."""
        return Rough(self.edge, self.roughly, edge=self.edge, holds="point", steep=2 * self.height / self.width)

    def known(self) -> dict[str, float]:
        """Return its width and height, m, and its stiffness, N/m."""
        return {"width": self.width, "height": self.top - self.base, **super().known()}
