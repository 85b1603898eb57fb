"""A rectangular post with rounded edges, turned about its axis."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive
from stretch_bt.simulation.membrane.indenters.edges import edge_zones

__all__ = ["Box"]


@dataclass(frozen=True, slots=True)
class Box(Solid):
    """A face of `first` x `second`, m, its first side turned by `angle`, rad, from x to y; the origin as of a cube."""

    first: float
    second: float
    angle: float = 0.0
    edge: float = 1e-3

    def __post_init__(self) -> None:
        for name, value in (("first side", self.first), ("second side", self.second), ("edge fillet", self.edge)):
            positive(f"the {name} of a box", value)
        if not math.isfinite(self.angle):
            raise InvalidInput(f"the angle of a box must be a finite number of rad, not {self.angle!r}")
        if self.edge > min(self.first, self.second) / 2:
            most = min(self.first, self.second) / 2
            raise InvalidInput(
                f"the edge fillet must be at most half the shorter side, {most:g} m, not {self.edge:g} m"
            )

    @property
    def feature(self) -> float:
        """Radius of the fillet, m."""
        return self.edge

    @property
    def tip_radius(self) -> float:
        """Half its shorter side, m."""
        return min(self.first, self.second) / 2

    @property
    def flat(self) -> float:
        """Half the shorter side of its flat face, m."""
        return self.tip_radius - self.edge

    @property
    def post(self) -> bool:
        """True, also where its edge leaves no face."""
        return True

    @property
    def _halves(self) -> tuple[float, float]:
        return self.first / 2 - self.edge, self.second / 2 - self.edge

    @property
    def _turn(self) -> Array:
        """The (3, 3) rotation from the box's own axes."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return half the extent of its flat top along x and y, m, as the rotation leaves it."""
        (a, b), turn = self._halves, np.abs(rotation @ self._turn)
        return float(turn[0, 0] * a + turn[0, 1] * b), float(turn[1, 0] * a + turn[1, 1] * b)

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m."""
        from stretch_bt.simulation.membrane.indenters.distance_kernel import prism, rotate

        gap, turn = empty_gap(len(points)), self._turn
        prism(np.ascontiguousarray(points @ turn), *self._halves, self.edge, *gap)
        rotate(turn, gap.normal, gap.curvature)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of the raised corner above the origin, m."""
        a, b = self._halves
        lift = np.abs((rotation @ self._turn)[2])
        return self.edge + float(a * lift[0] + b * lift[1])

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return the extent of its edges: strips along those that run along an axis, else all in between."""
        return edge_zones(self._halves, self.edge, rotation @ self._turn, gauge, turned=True)
