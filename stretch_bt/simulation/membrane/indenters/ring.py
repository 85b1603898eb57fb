"""A closed circle of round wire that lies flat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Zone, empty_gap, positive, spacing
from stretch_bt.simulation.membrane.indenters.round_wire import RoundWire

__all__ = ["Ring"]


@dataclass(frozen=True, slots=True)
class Ring(RoundWire):
    """A torus around z of a wire of `diameter`; `across` is the diameter of the circle that its axis makes, m."""

    diameter: float
    across: float

    def __post_init__(self) -> None:
        positive("the diameter of a ring's wire", self.diameter)
        positive("the diameter of a ring", self.across)
        if self.across <= self.diameter:
            raise InvalidInput("a ring must be wider than its wire is thick, or it has no hole")

    @property
    def peak(self) -> tuple[float, float]:
        """On the wire: its top is a circle, and on its axis there is nothing."""
        return self.across / 2, 0.0

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return the extent of the circle along x and y, m."""
        x, y = self._extent(rotation)
        return x, y

    def _extent(self, rotation: Array) -> list[float]:
        return [float(v) for v in self.across / 2 * np.hypot(rotation[:2, 0], rotation[:2, 1])]

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m, from its middle."""
        from stretch_bt.simulation.membrane.indenters.loops_kernel import ring

        gap = empty_gap(len(points))
        ring(points, self.across / 2, self.diameter / 2, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of its raised side above the middle, m."""
        return self.diameter / 2 + self.across / 2 * float(np.hypot(rotation[2, 0], rotation[2, 1]))

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return all that the circle spans."""
        size = 3 * spacing(self.diameter / 2, gauge)
        x, y = ([Zone(-half - 2 * size, half + 2 * size, size)] for half in self._extent(rotation))
        return x, y
