"""The skirt around an ellipse, cell by cell, compiled; conformal.py says what it is.

Complex numbers are written out: their library functions guard against overflow, which takes most of the time.
"""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["fill_skirt"]

FARTHEST = 4.0  # tau, beyond which the skirt is level
LEAST = 1e-18  # of a squared modulus


@kernel()
def outer_root(wx: Any, wy: Any, m: Any) -> Any:
    """Return the larger root of zeta + m / zeta = w."""
    px, py = wx * wx - wy * wy - 4.0 * m, 2.0 * wx * wy
    size = math.sqrt(px * px + py * py)
    rx = math.sqrt(max(0.5 * (size + px), 0.0))
    ry = math.copysign(math.sqrt(max(0.5 * (size - px), 0.0)), py)
    if wx * rx + wy * ry < 0.0:
        rx, ry = -rx, -ry
    return 0.5 * (wx + rx), 0.5 * (wy + ry)


@kernel(
    "void(float64[::1],float64[::1],float64[::1],float64[::1],float64,float64[::1],float64[:,::1],float64[:,::1],float64[::1])"
)
def fill_skirt(rim: Any, c: Any, x: Any, y: Any, kink: Any, fall: Any, by_rim: Any, basis: Any, outside: Any) -> None:
    """Fill the fall (n,), its derivatives by the rim (5, n), the functions (7, n) and the distance from the rim (n,).

    `rim` is x, y, half_i, half_j, k; `c` are the seven coefficients. The kink at tau = 0 is rounded to
    (tau + width)^2 / (4 width), which keeps the line outside as it is.
    """
    k, a, b = rim[4], rim[2], rim[3] / rim[4]
    s, m = 0.5 * (a + b), (a - b) / (a + b)
    for n in range(x.size):
        wx, wy = (x[n] - rim[0]) / s, (y[n] - rim[1]) / (k * s)
        zx, zy = outer_root(wx, wy, m)
        square = max(zx * zx + zy * zy, LEAST)
        gx, gy = zx - m * zx / square, zy + m * zy / square  # zeta - m / zeta
        gap = max(gx * gx + gy * gy, LEAST)
        tx, ty = gx / gap, -gy / gap  # d log zeta / d w
        radius = math.sqrt(square)
        tau = math.log(radius)
        steepness = math.sqrt(tx * tx + ty * ty / (k * k)) / s
        outside[n] = tau / steepness
        width = kink * steepness
        if tau <= -width:
            fall[n] = 0.0
            for f in range(7):
                basis[f, n] = 0.0
            for f in range(5):
                by_rim[f, n] = 0.0
            continue
        t, slope, grow = tau, 1.0, radius
        if tau < width:
            t, slope = (tau + width) * (tau + width) / (4.0 * width), (tau + width) / (2.0 * width)
            grow = math.exp(t)
        elif tau > FARTHEST:
            t, slope, grow = FARTHEST, 0.0, math.exp(FARTHEST)
        c1, s1 = zx / radius, zy / radius
        c2, s2 = c1 * c1 - s1 * s1, 2.0 * c1 * s1
        sinh1, cosh1 = 0.5 * (grow - 1.0 / grow), 0.5 * (grow + 1.0 / grow)
        sinh2, cosh2 = 2.0 * sinh1 * cosh1, 1.0 + 2.0 * sinh1 * sinh1
        half = 0.5 * t * t
        basis[0, n], basis[1, n], basis[2, n] = t, sinh1 * c1, sinh1 * s1
        basis[3, n], basis[4, n] = 0.5 * sinh2 * c2, 0.5 * sinh2 * s2
        basis[5, n], basis[6, n] = half, half * c2
        total = c[0] * t + sinh1 * (c[1] * c1 + c[2] * s1) + 0.5 * sinh2 * (c[3] * c2 + c[4] * s2)
        fall[n] = total + half * (c[5] + c[6] * c2)
        along = c[0] + cosh1 * (c[1] * c1 + c[2] * s1) + cosh2 * (c[3] * c2 + c[4] * s2) + t * (c[5] + c[6] * c2)
        along *= slope
        around = sinh1 * (c[2] * c1 - c[1] * s1) + sinh2 * (c[4] * c2 - c[3] * s2) - t * t * c[6] * s2
        # the change of the fall with w is (along - i around) d log zeta: its real part for a real change of w
        px, py = along * tx + around * ty, around * tx - along * ty
        by_s = -(px * wx + py * wy) / s
        by_m = -(px * zx - py * zy) / square  # a change of m by 1 is one of w by -1 / zeta
        by_b = 0.5 * by_s - (1.0 + m) / (2.0 * s) * by_m
        by_rim[0, n] = -px / s
        by_rim[1, n] = -py / (s * k)
        by_rim[2, n] = 0.5 * by_s + (1.0 - m) / (2.0 * s) * by_m
        by_rim[3, n] = by_b / k
        by_rim[4, n] = -0.5 * (b * by_b + py * wy)
