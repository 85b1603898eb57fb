"""Straight lengths of round wire, bent into a closed polygon that lies flat."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive, spacing

__all__ = ["WirePolygon"]


@dataclass(frozen=True, slots=True)
class WirePolygon(Solid):
    """A wire of `diameter` along a regular polygon with `count` sides of length `side`, m; its first corner lies on y."""

    diameter: float
    side: float
    count: int = 3

    def __post_init__(self) -> None:
        positive("the diameter of a wire", self.diameter)
        positive("the side of a wire polygon", self.side)
        if not 3 <= self.count <= 100:
            raise InvalidInput(f"a polygon has 3 to 100 sides, not {self.count}")
        if self.side <= 2 * self.diameter:
            raise InvalidInput("the sides of a wire polygon must be longer than two diameters, or it has no hole")

    @property
    def _corners(self) -> Array:
        """Places (count, 2), m, of its corners around the origin."""
        turns = math.pi / 2 + 2 * math.pi * np.arange(self.count) / self.count
        return self.side / (2 * math.sin(math.pi / self.count)) * np.column_stack([np.cos(turns), np.sin(turns)])

    @property
    def feature(self) -> float:
        """Radius of the wire, m."""
        return self.diameter / 2

    @property
    def bulk(self) -> float:
        """Thickness of the wire, m."""
        return self.diameter

    @property
    def peak(self) -> tuple[float, float]:
        """The middle of its first side."""
        x, y = self._corners[:2].mean(axis=0).tolist()
        return x, y

    def _turned(self, rotation: Array) -> Array:
        return self._corners @ rotation[:, :2].T

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return how far it reaches along x and y, m."""
        x, y, _ = np.abs(self._turned(rotation)).max(axis=0).tolist()
        return x, y

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m, from its middle."""
        from stretch_bt.simulation.membrane.indenters.loops_kernel import polygon

        gap = empty_gap(len(points))
        polygon(points, np.ascontiguousarray(self._corners), self.diameter / 2, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of its highest corner above the middle, m."""
        return self.diameter / 2 + float(self._turned(rotation)[:, 2].max())

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return all that it spans."""
        size = 3 * spacing(self.diameter / 2, gauge)
        places = self._turned(rotation)
        low, high = places.min(axis=0) - 2 * size, places.max(axis=0) + 2 * size
        x, y = ([Zone(float(low[c]), float(high[c]), size)] for c in range(2))
        return x, y
