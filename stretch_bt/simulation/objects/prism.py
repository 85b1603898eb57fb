"""A triangular prism that lies on a face."""

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

__all__ = ["PrismObject"]


class PrismObject(SolidSpec):
    """A triangular prism that lies on a face, its ridge along x."""

    type: Literal["prism"]
    length: Annotated[Length, Within(0.005, 0.3, "Length")] = Field(description="length of its ridge, along x")
    width: Annotated[Length, Within(0.005, 0.3, "Length")] = Field(description="width of the face it lies on, along y")
    height: Annotated[Length, Within(0.003, 0.3, "Length")] = Field(description="height of its ridge, edges sharp")
    edge: Annotated[Length, Within(0.0002, 0.010, "Length")] = Field(default=0.001, description="radius of its edges")

    @property
    def _lost(self) -> float:
        """Height of the sharp ridge over the rounded one, m."""
        return self.edge * (math.hypot(1.0, 2 * self.height / self.width) - 1)

    @property
    def top(self) -> float:
        """World height of its rounded ridge, m."""
        return self.base + self.height - self._lost

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return math.hypot(self.length, self.width) / 2

    def body(self) -> Polyhedron:
        """Return a prism with rounded edges."""
        from stretch_bt.simulation.membrane.indenters.shapes import triangular_prism

        return triangular_prism(self.length, self.width, self.height, self.edge)

    def rough(self) -> Rough:
        """Return the radius and the length of its ridge, and its stiffness."""
        return Rough(self.edge, self.roughly, edge=self.edge, face=self.length / 4, holds="ridge")

    def known(self) -> dict[str, float]:
        """Return its length, width and height, m, and its stiffness, N/m."""
        return {"length": self.length, "width": self.width, "height": self.top - self.base, **super().known()}
