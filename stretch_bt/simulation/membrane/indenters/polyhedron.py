"""A body bounded by flat triangles, its edges rounded."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive, spacing
from stretch_bt.simulation.membrane.indenters.surface import Triangles

__all__ = ["Polyhedron"]

_CROWN = 0.02  # how far below the top counts as the top, over half the body's width
_LEVEL = 0.999


@dataclass(frozen=True, eq=False, repr=False)
class Polyhedron(Solid):
    """A closed surface of `vertices` (n, 3), m, and `triangles` (m, 3), counter-clockwise from outside; rounded by `edge`, m.

    The faces of a convex body keep their places: its core, which the rounding is added to, is smaller by the fillet. The
    origin is the vertices', z up. `endless` says that it goes on downwards from its lowest face.

    Raises
    ------
    InvalidInput
        The surface is empty, open or inside out, or somewhere thinner than two fillets.
    """

    vertices: Array
    triangles: Array
    edge: float = 1e-3
    endless: bool = True
    core: Triangles = field(init=False)

    def __post_init__(self) -> None:
        positive("the edge fillet of a polyhedron", self.edge)
        surface = Triangles(self.vertices, self.triangles)
        surface.vertices.flags.writeable = surface.triangles.flags.writeable = False
        object.__setattr__(self, "vertices", surface.vertices)
        object.__setattr__(self, "triangles", surface.triangles)
        object.__setattr__(self, "core", surface.inward(self.edge))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Polyhedron):
            return NotImplemented
        return self is other or self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __repr__(self) -> str:
        # solved presses are kept by this text
        digest = hashlib.sha256(self._key[0] + self._key[1]).hexdigest()[:8]
        return (
            f"Polyhedron({len(self.vertices)} vertices, {len(self.triangles)} triangles, edge={self.edge:g}, {digest})"
        )

    @cached_property
    def _key(self) -> tuple[bytes, bytes, float, bool]:
        return self.vertices.tobytes(), self.triangles.tobytes(), self.edge, self.endless

    @property
    def feature(self) -> float:
        """Radius of the fillet, m."""
        return self.edge

    @property
    def tip_radius(self) -> float:
        """Radius of its level top, m, else of the fillet."""
        return max(self._level, self.edge)

    @property
    def bulk(self) -> float:
        """Its height, m, or endless."""
        return math.inf if self.endless else float(np.ptp(self.vertices[:, 2]))

    @cached_property
    def flat(self) -> float:
        """Radius of the disc that has the area of its level top, half the length of a ridge, or 0 for a point, m."""
        crown = self._crown(np.eye(3))
        ridge = float(np.hypot(*np.ptp(crown[:, :2], axis=0))) / 2
        return self._level or (ridge if ridge > self.edge else 0.0)

    @cached_property
    def _level(self) -> float:
        """Radius of the disc that has the area of its level top, m."""
        core = self.core
        upper = core.corners[:, :, 2].min(axis=1) > core.vertices[:, 2].max() - _CROWN * self._half
        area = float(core.areas[upper & (core.faces[:, 2] > _LEVEL)].sum())
        return math.sqrt(area / math.pi)

    @cached_property
    def _half(self) -> float:
        """Half its narrower width, m."""
        return float(np.ptp(self.vertices[:, :2], axis=0).min()) / 2

    def _crown(self, rotation: Array) -> Array:
        """Return the corners (n, 3), m, of the core that are highest after a rotation."""
        core = self.core
        places = core.vertices @ rotation.T
        return np.asarray(places[places[:, 2] >= places[:, 2].max() - _CROWN * self._half])

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Place (x, y), m, of the middle of its top where that is on the body, else of the highest corner next to it."""
        crown = self._crown(np.eye(3))
        middle = (crown.min(axis=0) + crown.max(axis=0)) / 2
        over = np.array([[middle[0], middle[1], crown[:, 2].max() + self.edge]])
        if self.gap(over).distance[0] > _CROWN * self._half:
            highest = crown[crown[:, 2] >= crown[:, 2].max() - 1e-3 * self.edge]
            middle = highest[np.argmin(np.linalg.norm(highest - middle, axis=1))]
        return float(middle[0]), float(middle[1])

    @property
    def sunk(self) -> float:
        """Height that its highest corner loses by the rounding, m."""
        return float(self.vertices[:, 2].max()) - self.top(np.eye(3))

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return how far its top reaches from the origin along x and y, m."""
        x, y, _ = np.abs(self._crown(rotation)).max(axis=0).tolist()
        return x, y

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m."""
        from stretch_bt.simulation.membrane.indenters.triangles_kernel import rounded

        core = self.core
        gap = empty_gap(len(points))
        rounded(np.ascontiguousarray(points), core.sorted_corners, core.sorted_normals, *core.tree, self.edge, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of its highest point above the origin, m."""
        core = self.core
        return self.edge + float((core.vertices @ rotation[2]).max())

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return its top and a little around it; strips along those edges of a level top that run along an axis."""
        # a point carries all of the force on its fillet, a ridge or a face spreads it along its edges
        size = spacing(self.edge, gauge) * (3 if self.flat else 1)
        places, around = self._crown(rotation), self.edge + (1.5 if self.flat else 4) * size
        x, y = (self._along(np.unique(np.round(places[:, c], 9)), around, size) for c in range(2))
        return x, y

    def _along(self, places: Array, around: float, size: float) -> list[Zone]:
        low, high = float(places[0]), float(places[-1])
        if self._level and len(places) == 2 and high - low > 2 * around:
            return [Zone(p - around, p + around, size) for p in (low, high)]
        return [Zone(low - around, high + around, size)]
