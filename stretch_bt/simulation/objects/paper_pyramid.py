"""A pyramid folded from paper."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from stretch_bt.simulation.objects.base import Rough
from stretch_bt.simulation.objects.paper import PaperSpec, Walls
from stretch_bt.simulation.objects.pyramid import blunt
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron

__all__ = ["PaperPyramid"]


class PaperPyramid(PaperSpec):
    """A pyramid folded from paper on a square, open below; it has no roof that could sag."""

    effects: ClassVar[tuple[str, ...]] = ("compliance", "rigid_shift")

    type: Literal["paper_pyramid"]
    width: Annotated[Length, Within(0.01, 0.2, "Length")] = Field(description="side of its square")
    height: Annotated[Length, Within(0.005, 0.2, "Length")] = Field(description="height of its point, folds sharp")

    @property
    def _slant(self) -> float:
        return math.hypot(self.height, self.width / 2)

    @property
    def top(self) -> float:
        """World height of its rounded point, m."""
        return self.base + self.height - blunt(self.width, self.height, self.edge)

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return self.width / math.sqrt(2)

    @property
    def walls(self) -> Walls:
        """Its four faces, as plates of their mean width."""
        return Walls(4, self.width / 2, self._slant)

    @property
    def face(self) -> float:
        """None: it ends in a point."""
        return 0.0

    @property
    def area(self) -> float:
        """Area of its faces, m^2."""
        return 2 * self.width * self._slant

    def body(self) -> Polyhedron:
        """Return a pyramid with rounded edges."""
        from stretch_bt.simulation.membrane.indenters.shapes import pyramid

        return pyramid(self.width, self.height, self.edge)

    def rough(self) -> Rough:
        """Return the rough numbers of paper, with the slope of its faces."""
        return replace(super().rough(), holds="point", steep=2 * self.height / self.width)

    def known(self) -> dict[str, float]:
        """Return its width and height, m."""
        return {"width": self.width, "height": self.top - self.base}
