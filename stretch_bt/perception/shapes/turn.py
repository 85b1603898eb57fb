"""Axes of a shape, and small rotations of them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["standing", "turned"]

Array = npt.NDArray[np.float64]


def standing(normal: Array, along: Array) -> Array:
    """Return a right-handed frame (3, 3) by rows: `along` freed of its part along `normal`, a third axis, `normal`."""
    n = normal / np.linalg.norm(normal)
    a = along - (along @ n) * n
    a /= np.linalg.norm(a)
    return np.array([a, np.cross(n, a), n])


def turned(axes: Array, angles: Array) -> Array:
    """Return axes (3, 3), by rows, after a rotation by small `angles` (3,), rad, about themselves, orthonormal again."""
    a, b, n = axes
    p, q, r = angles
    # Each axis moves by the cross product of the rotation p a + q b + r n with it.
    return standing(n - p * b + q * a, a - q * n + r * b)
