"""A round wire, bent into a closed polygon that lies flat."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Zone, empty_gap, positive, spacing
from stretch_bt.simulation.membrane.indenters.round_wire import RoundWire

__all__ = ["WirePolygon"]


@dataclass(frozen=True, slots=True)
class WirePolygon(RoundWire):
    """A wire of `diameter` along a regular polygon with `count` sides of length `side`, m; its first corner lies on y.

    `bend` is the radius at which the middle of the wire goes round the corners, m.
    """

    diameter: float
    side: float
    count: int = 3
    bend: float = 0.0

    def __post_init__(self) -> None:
        positive("the diameter of a wire", self.diameter)
        positive("the side of a wire polygon", self.side)
        if not 3 <= self.count <= 100:
            raise InvalidInput(f"a polygon has 3 to 100 sides, not {self.count}")
        if self.side <= 2 * self.diameter:
            raise InvalidInput("the sides of a wire polygon must be longer than two diameters, or it has no hole")
        if not 0 <= self.bend < self._inside - self.diameter:
            raise InvalidInput(
                "the bends of a wire polygon must have a radius of at least 0 m that leaves straight sides"
            )

    @property
    def _inside(self) -> float:
        """Radius of the circle that touches the middles of its sides, m."""
        return self.side / (2 * math.tan(math.pi / self.count))

    @property
    def _corners(self) -> Array:
        """Places (count, 2), m, of the corners of the polygon that the wire runs around at the radius of its bends."""
        turns = math.pi / 2 + 2 * math.pi * np.arange(self.count) / self.count
        out = (self._inside - self.bend) / math.cos(math.pi / self.count)
        return out * np.column_stack([np.cos(turns), np.sin(turns)])

    @property
    def peak(self) -> tuple[float, float]:
        """The middle of its first side."""
        turn = math.pi / 2 + math.pi / self.count
        return self._inside * math.cos(turn), self._inside * math.sin(turn)

    def _turned(self, rotation: Array) -> Array:
        return self._corners @ rotation[:, :2].T

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return how far it reaches along x and y, m."""
        x, y, _ = (np.abs(self._turned(rotation)).max(axis=0) + self.bend).tolist()
        return x, y

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m, from its middle."""
        from stretch_bt.simulation.membrane.indenters.loops_kernel import polygon

        gap = empty_gap(len(points))
        polygon(points, np.ascontiguousarray(self._corners), self.bend, self.diameter / 2, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of its highest corner above the middle, m."""
        lean = float(np.hypot(rotation[2, 0], rotation[2, 1]))
        return self.diameter / 2 + self.bend * lean + float(self._turned(rotation)[:, 2].max())

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return all that it spans."""
        size = 3 * spacing(self.diameter / 2, gauge)
        places = self._turned(rotation)
        around = self.bend + 2 * size
        low, high = places.min(axis=0) - around, places.max(axis=0) + around
        x, y = ([Zone(float(low[c]), float(high[c]), size)] for c in range(2))
        return x, y
