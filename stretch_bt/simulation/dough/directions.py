"""Directions spread evenly over the sphere, and the weights that differentiate a function given on them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput

__all__ = ["Directions", "directions"]

Array = npt.NDArray[np.float64]

NEIGHBOURS = 8
LEAST, MOST = 50, 20000


@dataclass(frozen=True, eq=False)
class Directions:
    """Unit vectors (n, 3), their neighbours (n, k), and weights (n, k, 3) of first and second derivatives.

    Of a function f on the sphere, the weights times f(neighbour) - f(direction) are its slopes along two perpendicular
    tangents and its surface Laplacian.
    """

    vectors: Array
    neighbours: npt.NDArray[np.int64]
    weights: Array

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.vectors)

    @property
    def solid_angle(self) -> float:
        """Solid angle of each of them, sr."""
        return 4 * math.pi / self.count


@lru_cache(maxsize=8)
def directions(count: int) -> Directions:
    """Return directions on a Fibonacci lattice, each of the same solid angle (Swinbank & Purser 2006, equation 1).

    Raises
    ------
    InvalidInput
        There are fewer than 50 or more than 20000.
    """
    if not LEAST <= count <= MOST:
        raise InvalidInput(f"a lump has {LEAST} to {MOST} directions, not {count}")
    index = np.arange(count)
    z = 1 - (2 * index + 1) / count
    azimuth = index * math.pi * (3 - math.sqrt(5))
    across = np.sqrt(1 - z**2)
    vectors = np.column_stack([across * np.cos(azimuth), across * np.sin(azimuth), z])
    neighbours, weights = _stencils(vectors)
    return Directions(vectors, neighbours, weights)


def _stencils(vectors: Array) -> tuple[npt.NDArray[np.int64], Array]:
    """Return neighbours (n, k) and weights (n, k, 3) of a quadratic fitted by least squares in each tangent plane."""
    from scipy.spatial import KDTree

    neighbours = np.asarray(KDTree(vectors).query(vectors, NEIGHBOURS + 1)[1], np.int64)[:, 1:]
    other = np.where(np.abs(vectors[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(vectors, other)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(vectors, first)
    near = vectors[neighbours]
    # arc length over chord: coordinates in which a great circle is a straight line
    cosine = np.clip(np.einsum("nkc,nc->nk", near, vectors), -1.0, 1.0)
    stretch = np.arccos(cosine) / np.sqrt(1 - cosine**2)
    u = np.einsum("nkc,nc->nk", near, first) * stretch
    v = np.einsum("nkc,nc->nk", near, second) * stretch
    fitted = np.linalg.pinv(np.stack([u, v, u * u / 2, u * v, v * v / 2], axis=2))
    weights = np.stack([fitted[:, 0], fitted[:, 1], fitted[:, 2] + fitted[:, 4]], axis=2)
    return np.ascontiguousarray(neighbours), np.ascontiguousarray(weights)
