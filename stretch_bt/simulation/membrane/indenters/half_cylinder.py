"""A half-cylinder that lies on its flat side."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive, spacing
from stretch_bt.simulation.membrane.indenters.wire import along

__all__ = ["HalfCylinder"]


@dataclass(frozen=True, slots=True)
class HalfCylinder(Solid):
    """Round on top, of `diameter`, its axis of `length` along x at z = 0, on a shank; the rims of its ends filleted, m."""

    diameter: float
    length: float
    edge: float = 1e-3

    def __post_init__(self) -> None:
        for name, value in (("diameter", self.diameter), ("length", self.length), ("edge fillet", self.edge)):
            positive(f"the {name} of a half-cylinder", value)
        if self.edge >= min(self.diameter, self.length) / 2:
            raise InvalidInput(
                f"the edge fillet of a half-cylinder must be below half its diameter and length, not {self.edge * 1e3:g} mm; write a smaller edge"
            )

    @property
    def feature(self) -> float:
        """Radius of the fillet, m."""
        return self.edge

    @property
    def tip_radius(self) -> float:
        """Its radius, m."""
        return self.diameter / 2

    @property
    def _half(self) -> float:
        return self.length / 2 - self.edge

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return half the length of its crest along x and y, m."""
        return abs(float(rotation[0, 0])) * self._half, abs(float(rotation[1, 0])) * self._half

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m."""
        from stretch_bt.simulation.membrane.indenters.loops_kernel import vault

        gap = empty_gap(len(points))
        vault(points, self._half, self.diameter / 2 - self.edge, self.edge, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of its highest point above the origin, m; a tilt about x turns it about its axis."""
        lean = math.hypot(float(rotation[2, 1]), float(rotation[2, 2]))
        core = self.diameter / 2 - self.edge
        return self.edge + core * lean + self._half * abs(float(rotation[2, 0]))

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return its crest, finer where it runs along an axis and at its ends."""
        size = min(spacing(self.diameter / 2, gauge), 4 * spacing(self.edge, gauge))
        x, y = np.abs(rotation[:2, 0]) * self.length / 2
        return along(float(x), float(y), size), along(float(y), float(x), size)
