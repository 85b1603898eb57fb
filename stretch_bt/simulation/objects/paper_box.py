"""A box folded from paper."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stretch_bt.simulation.objects.base import Rough, turned_aspect
from stretch_bt.simulation.objects.paper import PaperSpec, Walls
from stretch_bt.simulation.objects.roof import RoofResponse
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.box import Box

__all__ = ["PaperBox"]

_BENDS = 0.00406  # w D / (p b^4), a simply supported square plate (Timoshenko and Woinowsky-Krieger, table 8)
_STRETCHES = 0.802  # w / (a (p a / (E t))^(1/3)), a square membrane of half side a (the same, section 101)


class PaperBox(PaperSpec):
    """A box folded from paper, its length along x: four walls and a flat roof, open below."""

    type: Literal["paper_box"]
    length: Annotated[Length, Within(0.01, 0.2, "Length")] = Field(description="length along x")
    width: Annotated[Length, Within(0.01, 0.2, "Length")] = Field(description="width along y")
    height: Annotated[Length, Within(0.005, 0.2, "Length")]

    @property
    def top(self) -> float:
        """World height of its roof, m."""
        return self.base + self.height

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return math.hypot(self.length, self.width) / 2

    @property
    def walls(self) -> Walls:
        """Four walls of its mean width."""
        return Walls(4, (self.length + self.width) / 2, self.height)

    @property
    def face(self) -> float:
        """Radius of the disc that has the area of its roof, m."""
        return math.sqrt(self.length * self.width / math.pi)

    @property
    def area(self) -> float:
        """Area of roof and walls, m^2."""
        return self.length * self.width + 2 * (self.length + self.width) * self.height

    def roof(self, share: float) -> RoofResponse:
        """Return the sag of a square plate of its shorter side under an even pressure: bending, and tension beside it."""
        span, area = min(self.length, self.width), self.length * self.width
        half = span / 2
        linear = self.bending_stiffness / (_BENDS * span**4)
        cubic = self.modulus * self.thickness / (half * (_STRETCHES * half) ** 3)
        return RoofResponse(linear * area / share, cubic * area / share)

    def body(self) -> Box:
        """Return a post with its top."""
        from stretch_bt.simulation.membrane.indenters.box import Box

        return Box(self.length, self.width, edge=self.edge)

    def rough(self) -> Rough:
        """Return the rough numbers of paper, with its flat roof."""
        return replace(super().rough(), holds="rim", aspect=turned_aspect(self.length, self.width, self.heading))

    def known(self) -> dict[str, float]:
        """Return its length, width and height, m."""
        return {"length": self.length, "width": self.width, "height": self.height}
