"""A straight length of round wire."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Zone, empty_gap, positive, spacing
from stretch_bt.simulation.membrane.indenters.round_wire import RoundWire

__all__ = ["Wire", "along"]


@dataclass(frozen=True, slots=True)
class Wire(RoundWire):
    """A wire of `diameter` and `length` with round ends, m, lying flat at `heading`, rad, from x."""

    diameter: float
    length: float
    heading: float = 0.0

    def __post_init__(self) -> None:
        positive("the diameter of a wire", self.diameter)
        positive("the length of a wire", self.length)

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return half the length along x and along y, m."""
        x, y, _ = self._half(rotation).tolist()
        return abs(x), abs(y)

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m, from the middle of the wire."""
        import numpy as np

        from stretch_bt.simulation.membrane.indenters.distance_kernel import capsule, rotate

        c, s = math.cos(self.heading), math.sin(self.heading)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        gap = empty_gap(len(points))
        capsule(np.ascontiguousarray(points @ turn), self.length / 2, self.diameter / 2, *gap)
        rotate(turn, gap.normal, gap.curvature)
        return gap

    def _half(self, rotation: Array) -> Array:
        import numpy as np

        return np.asarray(rotation @ np.array([math.cos(self.heading), math.sin(self.heading), 0.0]) * self.length / 2)

    def top(self, rotation: Array) -> float:
        """Return the height of the raised end above the middle, m."""
        return self.diameter / 2 + abs(float(self._half(rotation)[2]))

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return narrow zones where the wire runs along an axis, and zones at its ends."""
        size = spacing(self.diameter / 2, gauge) * 1.5
        x, y = (abs(float(v)) for v in self._half(rotation)[:2])
        return along(x, y, size), along(y, x, size)


def along(reach: float, across: float, size: float) -> list[Zone]:
    """Return zones on one axis for a wire that spans `reach` to either side there and `across` on the other axis."""
    if reach <= 2 * size:
        return [Zone(-reach - 2 * size, reach + 2 * size, size)]
    ends = [Zone(sign * reach - 1.5 * size, sign * reach + 1.5 * size, size) for sign in (-1, 1)]
    middle = [Zone(-reach, reach, size * max(1.0, min(reach / max(across, 1e-12), 4.0)))]
    return ends + middle
