"""Heights of a sphere, and of one with a membrane's skirt, with all derivatives, compiled; the surfaces say what they are."""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["fill_cap", "fill_sphere"]

STEEPEST = 1e-4  # least squared cosine between ray and normal; beyond it is the silhouette
STEEPEST_SKIRT = 1e-2  # the same where its derivatives are continued


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


@kernel("void(float64[::1],float64[::1],float64[::1],float64[::1],float64[:,::1])")
def fill_cap(q: Any, x: Any, y: Any, height: Any, jacobian: Any) -> None:
    """Fill the height (n,) of a CapSurface and its derivatives (8, n) at places (n,).

    With v = (x, y) less the rim there, and t = |v| over the size of the rim, the skirt is S + grad S v + v H v / 2 and
    J / g t^2 / 2, where g is the squared slope of the rim's equation. The first three are a Taylor series: where the rim
    moves, only its third derivative is left.
    """
    c, p1, p2, k = q[0], q[1], q[2], q[3]
    a2, b2 = math.exp(-2.0 * q[4]), math.exp(-2.0 * q[5])
    d0 = 1.0 / math.sqrt(1.0 + p1 * p1 + p2 * p2)
    sx, sy = p1 * d0, p2 * d0
    for n in range(x.size):
        dx, dy = x[n] - q[6], y[n] - q[7]
        rims = math.sqrt(dx * dx * a2 + dy * dy * b2)
        on = 1.0 / max(rims, 1.0)
        rx, ry = dx * on, dy * on
        at_x, at_y = q[6] + rx, q[7] + ry
        ux, uy = k * at_x - sx, k * at_y - sy
        r2 = at_x * at_x + at_y * at_y
        square = 1.0 - ux * ux - uy * uy
        d = math.sqrt(max(square, STEEPEST_SKIRT))
        i = 1.0 / d
        inner = i if square > STEEPEST_SKIRT else 0.0
        back = 1.0 / (d + d0)
        f = (2.0 * (sx * at_x + sy * at_y) - k * r2) * back
        by_sx = (2.0 * at_x - f * (ux * inner - sx / d0)) * back
        by_sy = (2.0 * at_y - f * (uy * inner - sy / d0)) * back
        u_at = ux * at_x + uy * at_y
        by_k = (-r2 + f * u_at * inner) * back
        jacobian[0, n] = 1.0
        for p in range(4, 8):
            jacobian[p, n] = 0.0
        if rims > 1.0:
            t = rims - 1.0
            w, rr, uu, at_r = ux * rx + uy * ry, rx * rx + ry * ry, ux * ux + uy * uy, at_x * rx + at_y * ry
            i3 = i * i * i
            nx, ny = rx * a2, ry * b2
            g = 1.0 / (nx * nx + ny * ny)
            bent, jump = rr * i + w * w * i3, 2.0 * i + uu * i3
            half = 0.5 * t * t
            whole = half * (g * jump - bent)
            f += -w * i * t + k * whole
            # by D alone, and then by what moves D
            bent_d, jump_d = -rr * i * i - 3.0 * w * w * i3 * i, -2.0 * i * i - 3.0 * uu * i3 * i
            by_d = w * i * i * t + k * half * (g * jump_d - bent_d)
            by_w = -i * t - 2.0 * k * half * w * i3
            by_uu = k * half * g * i3
            by_sx += by_d * ux * inner - by_w * rx - 2.0 * by_uu * ux
            by_sy += by_d * uy * inner - by_w * ry - 2.0 * by_uu * uy
            by_k += whole - by_d * u_at * inner + by_w * at_r + 2.0 * by_uu * u_at
            ex, ey = nx * rx, ny * ry
            for p in range(4):
                if p == 0:
                    grown, mx, my, g_by = -rims * ex, rx * ex, ry * ex, 2.0 * ex / g - 4.0 * nx * nx
                elif p == 1:
                    grown, mx, my, g_by = -rims * ey, rx * ey, ry * ey, 2.0 * ey / g - 4.0 * ny * ny
                elif p == 2:
                    grown, mx, my = -nx, (rx * nx - 1.0) / rims, ry * nx / rims
                    g_by = 2.0 * (nx * a2 * mx + ny * b2 * my)
                    mx += 1.0
                else:
                    grown, mx, my = -ny, rx * ny / rims, (ry * ny - 1.0) / rims
                    g_by = 2.0 * (nx * a2 * mx + ny * b2 * my)
                    my += 1.0
                moved_u, moved_r = k * (ux * mx + uy * my), mx * rx + my * ry
                moved_d = -moved_u * inner
                third = bent_d * moved_d + 2.0 * k * moved_r * w * i3
                jumped = jump_d * moved_d + 2.0 * moved_u * i3
                jacobian[4 + p, n] = k * (half * (g * jumped - g * g * g_by * jump - third) + t * grown * g * jump)
        height[n] = c + f
        jacobian[1, n] = d0 * ((1.0 - sx * sx) * by_sx - sx * sy * by_sy)
        jacobian[2, n] = d0 * ((1.0 - sy * sy) * by_sy - sx * sy * by_sx)
        jacobian[3, n] = by_k
