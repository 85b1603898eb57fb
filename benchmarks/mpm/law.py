"""What happens at one material point, compiled: its strain, its yield, its friction, and its place on the grid."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["returned", "rubbed", "spline", "strained"]

#: the order in which `numbers` (12,) holds size of a cell, m, step, s, volume of a point, m^3, density, kg/m^3, bulk and shear modulus
#: and yield stress, Pa, stiffness of table and hand, how far from a point its surface is, m, friction, and gravity, m/s^2
DX, DT, VOLUME, DENSITY, BULK, SHEAR, YIELD, TABLE, HAND, MARGIN, GRIP, GRAVITY = range(12)
_DAMPER = 0.2  # of the slip of a point alone that it takes away in a step


@kernel("UniTuple(float64, 6)(float64[:,::1], float64[::1], float64)")
def strained(grown: Any, before: Any, volume: Any) -> Any:
    """Return the isochoric left strain (xx, yy, zz, xy, xz, yz) after a step's gradient, whose determinant is `volume`."""
    b = np.empty((3, 3))
    b[0, 0], b[1, 1], b[2, 2] = before[0], before[1], before[2]
    b[0, 1] = b[1, 0] = before[3]
    b[0, 2] = b[2, 0] = before[4]
    b[1, 2] = b[2, 1] = before[5]
    scale = volume ** (-2.0 / 3.0)
    found = np.zeros((3, 3))
    for i in range(3):
        for j in range(i, 3):
            total = 0.0
            for k in range(3):
                for m in range(3):
                    total += grown[i, k] * b[k, m] * grown[j, m]
            found[i, j] = scale * total
    return found[0, 0], found[1, 1], found[2, 2], found[0, 1], found[0, 2], found[1, 2]


@kernel("float64(float64[::1], UniTuple(float64, 6), float64)")
def returned(strain: Any, trial: Any, limit: Any) -> Any:
    """Fill `strain` (6,) with the trial strain, its deviator no larger than `limit`, and return what was taken off it.

    The spherical part is the one that keeps the determinant 1: the root of p^3 - p J2 + J3 - 1 near 1.
    """
    third = (trial[0] + trial[1] + trial[2]) / 3.0
    x, y, z = trial[0] - third, trial[1] - third, trial[2] - third
    xy, xz, yz = trial[3], trial[4], trial[5]
    size = math.sqrt(x * x + y * y + z * z + 2.0 * (xy * xy + xz * xz + yz * yz))
    part = 1.0 if size <= limit else limit / size
    x, y, z, xy, xz, yz = part * x, part * y, part * z, part * xy, part * xz, part * yz
    second = 0.5 * (x * x + y * y + z * z) + xy * xy + xz * xz + yz * yz
    third_invariant = x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz)
    p = 1.0 + second / 3.0
    for _ in range(3):
        p -= (p**3 - second * p + third_invariant - 1.0) / (3.0 * p * p - second)
    strain[0], strain[1], strain[2] = x + p, y + p, z + p
    strain[3], strain[4], strain[5] = xy, xz, yz
    return (1.0 - part) * size


@kernel("UniTuple(float64, 2)(float64[::1], float64, float64, float64, float64[::1])")
def rubbed(crept: Any, push: Any, x: Any, y: Any, numbers: Any) -> Any:
    """Return the impulse, N s, of friction on a point pushed with `push`, N, that moves at (x, y), m/s, over what pushes it.

    It sticks by a spring with a damper to where it touched first, `crept` (2,), m, away, which is dragged along beyond the limit.
    """
    if push <= 0.0:
        crept[0] = crept[1] = 0.0
        return 0.0, 0.0
    dt, damper = numbers[DT], _DAMPER * numbers[VOLUME] * numbers[DENSITY] / numbers[DT]
    crept[0], crept[1] = crept[0] + x * dt, crept[1] + y * dt
    fx, fy = numbers[TABLE] * crept[0] + damper * x, numbers[TABLE] * crept[1] + damper * y
    part = min(numbers[GRIP] * push / max(math.sqrt(fx * fx + fy * fy), 1e-300), 1.0)
    if part < 1.0:
        crept[0], crept[1] = part * crept[0], part * crept[1]
    return -part * fx * dt, -part * fy * dt


@kernel("Tuple((int64, float64, float64, float64, float64))(float64)")
def spline(at: Any) -> Any:
    """Return the first of the three nodes around a place in units of the grid, how far past it that is, and their weights."""
    first = math.floor(at - 0.5)
    f = at - first
    return first, f, 0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2
