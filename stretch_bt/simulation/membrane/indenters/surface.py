"""A closed surface of triangles, and the data for the search of its nearest point."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array

__all__ = ["Triangles"]

Indices = npt.NDArray[np.int64]

_LEAF = 4
_RANK = 1e-3  # least eigenvalue over the largest: directions in which its planes hold a corner less stay as they are
_TURN = 0.5


class Triangles:
    """Vertices (n, 3), m, and triangles (m, 3), counter-clockwise from outside.

    Raises
    ------
    InvalidInput
        There are no triangles, one has no area, the surface is open, or it is inside out.
    """

    def __init__(self, vertices: Array, triangles: npt.ArrayLike) -> None:
        self.vertices = np.array(vertices, dtype=float)
        self.triangles = np.array(triangles, dtype=np.int64)
        if self.triangles.size == 0 or self.vertices.size == 0:
            raise InvalidInput("a body of triangles needs at least four; this one is empty")
        if self.vertices.shape[1:] != (3,) or self.triangles.shape[1:] != (3,):
            raise InvalidInput("a body of triangles needs vertices (n, 3) and triangles (m, 3)")
        if not np.isfinite(self.vertices).all():
            raise InvalidInput("the vertices of a body must be finite numbers, m")
        self._check_closed()
        if not self.areas.min() > 1e-12 * self.areas.max():
            raise InvalidInput("a triangle has no area; merge its corners")
        if np.einsum("mi,mi->", self.corners[:, 0], np.cross(self.corners[:, 1], self.corners[:, 2])) <= 0:
            raise InvalidInput(
                "the triangles enclose no volume, or face inwards; turn them counter-clockwise from outside"
            )

    def _check_closed(self) -> None:
        """Raise InvalidInput unless each edge is run through once in either direction."""
        edges = np.concatenate([self.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        if edges.min() < 0 or edges.max() >= len(self.vertices):
            raise InvalidInput(f"triangles must name vertices 0 to {len(self.vertices) - 1}")
        codes = edges[:, 0] * len(self.vertices) + edges[:, 1]
        back = edges[:, 1] * len(self.vertices) + edges[:, 0]
        lonely = int((~np.isin(codes, back)).sum())
        if lonely:
            raise InvalidInput(
                f"the surface is open, or not all of it faces outwards: {lonely} edges have one triangle only"
            )
        if len(np.unique(codes)) < len(codes):
            raise InvalidInput("more than two triangles meet in an edge of the surface")

    @cached_property
    def corners(self) -> Array:
        """Corners (m, 3, 3) of the triangles, m."""
        return np.ascontiguousarray(self.vertices[self.triangles])

    @cached_property
    def _doubled(self) -> Array:
        return np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])

    @cached_property
    def areas(self) -> Array:
        """Area (m,) of each triangle, m^2."""
        return np.asarray(np.linalg.norm(self._doubled, axis=1) / 2)

    @cached_property
    def faces(self) -> Array:
        """Outward unit normal (m, 3) of each triangle."""
        return np.asarray(self._doubled / (2 * self.areas[:, None]))

    @cached_property
    def _angles(self) -> Array:
        """Angle (m, 3), rad, of each triangle at each corner."""
        ahead = np.roll(self.corners, -1, axis=1) - self.corners
        behind = np.roll(self.corners, 1, axis=1) - self.corners
        sine = np.linalg.norm(np.cross(ahead, behind), axis=2)
        return np.asarray(np.arctan2(sine, np.einsum("mki,mki->mk", ahead, behind)))

    @cached_property
    def normals(self) -> Array:
        """Outward normals (m, 7, 3): of the face, of its edges (the mean of both faces), of its corners (by angle)."""
        at_corner = np.zeros_like(self.vertices)
        for k in range(3):
            np.add.at(at_corner, self.triangles[:, k], self._angles[:, k, None] * self.faces)
        made = np.empty((len(self.triangles), 7, 3))
        made[:, 0] = self.faces
        made[:, 4:] = at_corner[self.triangles]
        edges = np.concatenate([self.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        count = len(self.vertices)
        codes = edges.min(axis=1) * count + edges.max(axis=1)
        _, which = np.unique(codes, return_inverse=True)
        sums = np.zeros((which.max() + 1, 3))
        np.add.at(sums, which, np.tile(self.faces, (3, 1)))
        made[:, 1:4] = sums[which].reshape(3, -1, 3).transpose(1, 0, 2)
        return np.asarray(made / np.maximum(np.linalg.norm(made, axis=2, keepdims=True), 1e-300))

    def inward(self, distance: float) -> Triangles:
        """Return the surface with all its faces moved inwards, m, as far as their corners can follow.

        Raises
        ------
        InvalidInput
            A face would vanish or turn round: the body is thinner there than two distances.
        """
        held, pull = np.zeros((len(self.vertices), 3, 3)), np.zeros((len(self.vertices), 3))
        for k in range(3):
            weight = self._angles[:, k, None] * self.faces
            np.add.at(held, self.triangles[:, k], weight[:, :, None] * self.faces[:, None, :])
            np.add.at(pull, self.triangles[:, k], weight)
        shift = -distance * np.einsum("nij,nj->ni", np.linalg.pinv(held, rcond=_RANK, hermitian=True), pull)
        message = f"the body is thinner somewhere than two fillets of {distance * 1e3:.3g} mm; write a smaller edge"
        try:
            moved = Triangles(self.vertices + shift, self.triangles)
        except InvalidInput:
            raise InvalidInput(message) from None
        if np.einsum("mi,mi->m", moved.faces, self.faces).min() < _TURN:
            raise InvalidInput(message)
        return moved

    @cached_property
    def _order(self) -> tuple[Indices, Array, Indices]:
        """Triangles (m,) in the order of the leaves, boxes (b, 6) and links (b, 3) of the tree."""
        lows, highs, middles = self.corners.min(axis=1), self.corners.max(axis=1), self.corners.mean(axis=1)
        order = np.arange(len(lows))
        boxes, links = [np.empty(6)], [(0, 0, 0)]
        waiting = [(0, 0, len(lows))]
        while waiting:
            node, first, last = waiting.pop()
            held = order[first:last]
            boxes[node] = np.concatenate([lows[held].min(axis=0), highs[held].max(axis=0)])
            if last - first <= _LEAF:
                links[node] = (first, last, 0)
                continue
            half = (last - first) // 2
            axis = int(np.argmax(np.ptp(middles[held], axis=0)))
            order[first:last] = held[np.argpartition(middles[held, axis], half)]
            links[node] = (len(boxes), len(boxes) + 1, 1)
            waiting += [(len(boxes), first, first + half), (len(boxes) + 1, first + half, last)]
            boxes += [np.empty(6)] * 2
            links += [(0, 0, 0)] * 2
        return order, np.ascontiguousarray(boxes), np.array(links, dtype=np.int64)

    @property
    def tree(self) -> tuple[Array, Indices]:
        """Boxes (b, 6) and links (b, 3) as the kernel takes them."""
        return self._order[1], self._order[2]

    @cached_property
    def sorted_corners(self) -> Array:
        """Corners (m, 3, 3) in the order of the tree."""
        return np.ascontiguousarray(self.corners[self._order[0]])

    @cached_property
    def sorted_normals(self) -> Array:
        """Normals (m, 7, 3) in the order of the tree."""
        return np.ascontiguousarray(self.normals[self._order[0]])
