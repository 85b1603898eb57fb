"""A cube with rounded edges, one face towards the sheet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive
from stretch_bt.simulation.membrane.indenters.edges import edge_zones

__all__ = ["Cube"]


@dataclass(frozen=True, slots=True)
class Cube(Solid):
    """A face of `side`, m, on a post of that side, edges along x and y; the origin lies one fillet below the face."""

    side: float
    edge: float = 1e-3

    def __post_init__(self) -> None:
        positive("the side of a cube", self.side)
        positive("the edge fillet of a cube", self.edge)
        if self.edge > self.side / 2:
            raise InvalidInput(
                f"the edge fillet must be at most half the side, {self.side / 2:g} m, not {self.edge:g} m"
            )

    @property
    def feature(self) -> float:
        """Radius of the fillet, m."""
        return self.edge

    @property
    def tip_radius(self) -> float:
        """Half its side, m."""
        return self.side / 2

    @property
    def flat(self) -> float:
        """Half the side of its flat face, m."""
        return self.side / 2 - self.edge

    @property
    def post(self) -> bool:
        """True, also where its edge leaves no face."""
        return True

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return half the extent of its flat top along x and y, m, as the rotation leaves it."""
        along = self.flat * np.abs(rotation[:2, :2]).sum(axis=1)
        return float(along[0]), float(along[1])

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m."""
        from stretch_bt.simulation.membrane.indenters.distance_kernel import prism

        half, gap = self.side / 2 - self.edge, empty_gap(len(points))
        prism(points, half, half, self.edge, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of the raised corner above the origin, m."""
        half = self.side / 2 - self.edge
        return self.edge + half * float(abs(rotation[2, 0]) + abs(rotation[2, 1]))

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return a strip along each edge, as the rotation leaves it."""
        return edge_zones((self.flat, self.flat), self.edge, rotation, gauge, turned=False)
