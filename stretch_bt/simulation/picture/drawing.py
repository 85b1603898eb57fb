"""A drawing as a list of shapes, which SVG and pixels are made from alike; lengths in units of the drawing, y down."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Drawing", "Picture", "Polygon", "Polyline", "Shape", "Text"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Polygon:
    """A filled outline (n, 2)."""

    points: Array
    fill: str

    def moved(self, x: float, y: float) -> Polygon:
        """Return the shape moved by (x, y)."""
        return replace(self, points=self.points + np.array([x, y]))


@dataclass(frozen=True, slots=True)
class Polyline:
    """A line through points (n, 2)."""

    points: Array
    color: str
    width: float = 1.0
    dashed: bool = False

    def moved(self, x: float, y: float) -> Polyline:
        """Return the shape moved by (x, y)."""
        return replace(self, points=self.points + np.array([x, y]))


@dataclass(frozen=True, slots=True)
class Text:
    """A line of plain letters, anchored at its `start`, `middle` or `end`."""

    x: float
    y: float
    text: str
    anchor: str = "start"
    size: float = 12.0
    color: str = "#333333"

    def moved(self, x: float, y: float) -> Text:
        """Return the shape moved by (x, y)."""
        return replace(self, x=self.x + x, y=self.y + y)


@dataclass(frozen=True, slots=True)
class Picture:
    """An image (h, w, 3) uint8, red, green, blue, stretched over a rectangle."""

    x: float
    y: float
    width: float
    height: float
    image: Image

    def moved(self, x: float, y: float) -> Picture:
        """Return the shape moved by (x, y)."""
        return replace(self, x=self.x + x, y=self.y + y)


Shape = Polygon | Polyline | Text | Picture


@dataclass(slots=True)
class Drawing:
    """Shapes, the first at the bottom, on white."""

    width: float
    height: float
    title: str = ""
    shapes: list[Shape] = field(default_factory=list)

    def add(self, *shapes: Shape) -> None:
        """Add shapes on top."""
        self.shapes.extend(shapes)

    def line(self, points: Any, color: str, width: float = 1.0, dashed: bool = False) -> None:
        """Add a line."""
        self.add(Polyline(np.asarray(points, float), color, width, dashed))

    def polygon(self, points: Any, fill: str) -> None:
        """Add a filled outline."""
        self.add(Polygon(np.asarray(points, float), fill))

    def box(self, x0: float, y0: float, x1: float, y1: float, fill: str) -> None:
        """Add a filled rectangle."""
        self.polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], fill)

    def place(self, shapes: Iterable[Shape], x: float, y: float) -> None:
        """Add the shapes of another drawing, moved."""
        self.add(*(shape.moved(x, y) for shape in shapes))
