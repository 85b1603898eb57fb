"""A block with a rectangular top."""

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
    from stretch_bt.simulation.membrane.indenters.box import Box

__all__ = ["BoxObject"]


class BoxObject(SolidSpec):
    """A block with a rectangular top, its length along x."""

    type: Literal["box"]
    length: Annotated[Length, Within(0.0001, 0.3, "Length")] = Field(description="length along x")
    width: Annotated[Length, Within(0.0001, 0.3, "Length")] = Field(description="width along y")
    height: Annotated[Length, Within(0.0001, 0.5, "Length")]
    edge: Annotated[Length, Within(0.00005, 0.05, "Length")] = Field(
        default=0.001, description="radius of its edges, at most half its shorter side"
    )

    @model_validator(mode="after")
    def _round(self) -> BoxObject:
        if "edge" in self.model_fields_set and self.edge > min(self.length, self.width) / 2:
            raise InvalidInput("its edges are rounder than half its shorter side; write a smaller edge")
        return self

    @property
    def top(self) -> float:
        """World height of its top, m."""
        return self.base + self.height

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return math.hypot(self.length, self.width) / 2

    def body(self) -> Box:
        """Return a post with its top."""
        from stretch_bt.simulation.membrane.indenters.box import Box

        return Box(self.length, self.width, edge=min(self.edge, self.length / 2, self.width / 2))

    def rough(self) -> Rough:
        """Return half its shorter side, its stiffness and the disc that has the area of its top."""
        face = math.sqrt(self.length * self.width / math.pi)
        aspect = turned_aspect(self.length, self.width, self.heading)
        half = min(self.length, self.width) / 2
        return Rough(half, self.roughly, edge=self.edge, face=face, holds="rim", aspect=aspect)

    def known(self) -> dict[str, float]:
        """Return its length, width and height, m, and its stiffness, N/m."""
        return {"length": self.length, "width": self.width, "height": self.height, **super().known()}
