"""Heights of a sphere with all derivatives, compiled; SphereSurface says what they are."""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["fill_sphere"]

STEEPEST = 1e-4  # least squared cosine between ray and normal; beyond it is the silhouette


@kernel("void(float64[::1],float64[::1],float64[::1],float64[::1],float64[:,::1])")
def fill_sphere(q: Any, x: Any, y: Any, height: Any, jacobian: Any) -> None:
    """Fill the height (n,) of a SphereSurface and its derivatives (4, n) at places (n,)."""
    c, p1, p2, k = q[0], q[1], q[2], q[3]
    d0 = 1.0 / math.sqrt(1.0 + p1 * p1 + p2 * p2)
    sx, sy = p1 * d0, p2 * d0
    for n in range(x.size):
        ux, uy = k * x[n] - sx, k * y[n] - sy
        r2 = x[n] * x[n] + y[n] * y[n]
        square = 1.0 - ux * ux - uy * uy
        d = math.sqrt(max(square, STEEPEST))
        inner = 1.0 / d if square > STEEPEST else 0.0  # beyond the silhouette the surface continues at constant D
        back = 1.0 / (d + d0)
        f = (2.0 * (sx * x[n] + sy * y[n]) - k * r2) * back
        by_sx = (2.0 * x[n] - f * (ux * inner - sx / d0)) * back
        by_sy = (2.0 * y[n] - f * (uy * inner - sy / d0)) * back
        height[n] = c + f
        jacobian[0, n] = 1.0
        jacobian[1, n] = d0 * ((1.0 - sx * sx) * by_sx - sx * sy * by_sy)
        jacobian[2, n] = d0 * ((1.0 - sy * sy) * by_sy - sx * sy * by_sx)
        jacobian[3, n] = (-r2 + f * (ux * x[n] + uy * y[n]) * inner) * back
