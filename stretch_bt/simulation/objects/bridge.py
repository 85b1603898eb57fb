"""An arch block: a deck on two piers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.base import Rough, turned_aspect
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron

__all__ = ["BridgeObject"]


class BridgeObject(SolidSpec):
    """An arch block: a block, its length along x, with a half-round opening of `span` through it along y."""

    type: Literal["bridge"]
    length: Annotated[Length, Within(0.005, 0.3, "Length")] = Field(description="length along x")
    width: Annotated[Length, Within(0.005, 0.3, "Length")] = Field(description="width along y, also of the opening")
    height: Annotated[Length, Within(0.005, 0.5, "Length")]
    span: Annotated[Length, Within(0.002, 0.3, "Length")] = Field(description="diameter of the opening at the table")
    edge: Annotated[Length, Within(0.0002, 0.005, "Length")] = Field(default=0.001, description="radius of its edges")

    @model_validator(mode="after")
    def _piers(self) -> BridgeObject:
        if self.span / 2 + 2.5 * self.edge > min(self.height, self.length / 2):
            raise InvalidInput("the opening leaves no deck or no piers; write a smaller span")
        return self

    @property
    def top(self) -> float:
        """World height of its deck, m."""
        return self.base + self.height

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return math.hypot(self.length, self.width) / 2

    def body(self) -> Polyhedron:
        """Return deck and piers, the opening included."""
        from stretch_bt.simulation.membrane.indenters.shapes import arch

        return arch(self.length, self.width, self.height, self.span, self.edge)

    def rough(self) -> Rough:
        """Return half its shorter side, its stiffness and the disc that has the area of its deck."""
        face = math.sqrt(self.length * self.width / math.pi)
        aspect = turned_aspect(self.length, self.width, self.heading)
        half = min(self.length, self.width) / 2
        return Rough(half, self.roughly, edge=self.edge, face=face, holds="rim", aspect=aspect)

    def known(self) -> dict[str, float]:
        """Return its length, width, height and span, m, and its stiffness, N/m."""
        sizes = {"length": self.length, "width": self.width, "height": self.height, "span": self.span}
        return {**sizes, **super().known()}
