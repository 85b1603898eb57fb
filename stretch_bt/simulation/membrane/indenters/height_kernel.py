"""Distance to the ground under a height field, a bicubic spline over a rectangle with walls at its border, compiled.

The unit of length is the pitch of the grid; u runs from 0 to nx - 1 along x, v from 0 to ny - 1 along y. The distance is
that to the nearest point, which Newton's method finds from the point below and from the nearest node of a coarse search.
With tangents T (3, 2), G = T' T, the second derivatives B along the normal and the signed distance d, the normal n
changes by -T G^-1 B (G - d B)^-1 T' (do Carmo 1976, the Weingarten equations).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.simulation.membrane.indenters.distance_kernel import bend

__all__ = ["ground", "highest"]

_SEARCH = 16  # a coarse search looks at this many intervals to a side
_CLOSE = 1e-6  # of a pitch; Newton's next step would be lost in rounding


@kernel()
def cubic(t: Any) -> Any:
    """Return the four uniform cubic B-splines at t, from 0 to 1, with their first and second derivatives."""
    s = 1.0 - t
    return (
        (s * s * s / 6.0, (3.0 * t - 6.0) * t * t / 6.0 + 2.0 / 3.0, (3.0 * s - 6.0) * s * s / 6.0 + 2.0 / 3.0, t * t * t / 6.0),
        (-0.5 * s * s, (1.5 * t - 2.0) * t, (2.0 - 1.5 * s) * s, 0.5 * t * t),
        (s, 3.0 * t - 2.0, 3.0 * s - 2.0, t),
    )  # fmt: skip


@kernel()
def spline(coefficients: Any, u: Any, v: Any, out: Any) -> Any:
    """Fill out (6,) with height, slopes along u and v, and second derivatives uu, uv, vv; coefficients (ny + 2, nx + 2)."""
    i = min(int(u), coefficients.shape[1] - 4)
    j = min(int(v), coefficients.shape[0] - 4)
    (p0, p1, p2, p3), (q0, q1, q2, q3), (r0, r1, r2, r3) = cubic(u - i)
    value, slope, second = cubic(v - j)
    h = hu = hv = huu = huv = hvv = 0.0
    for k in range(4):
        row = coefficients[j + k]
        c0, c1, c2, c3 = row[i], row[i + 1], row[i + 2], row[i + 3]
        a = p0 * c0 + p1 * c1 + p2 * c2 + p3 * c3
        b = q0 * c0 + q1 * c1 + q2 * c2 + q3 * c3
        c = r0 * c0 + r1 * c1 + r2 * c2 + r3 * c3
        h, hu, huu = h + value[k] * a, hu + value[k] * b, huu + value[k] * c
        hv, huv, hvv = hv + slope[k] * a, huv + slope[k] * b, hvv + second[k] * a
    out[0], out[1], out[2], out[3], out[4], out[5] = h, hu, hv, huu, huv, hvv


@kernel()
def step(gu: Any, gv: Any, a: Any, b: Any, c: Any, u: Any, v: Any, most_u: Any, most_v: Any) -> Any:
    """Return Newton's step inside the rectangle, and which of u and v the border holds; downhill where not convex."""
    hold_u = (u <= 0.0 and gu > 0.0) or (u >= most_u and gu < 0.0)
    hold_v = (v <= 0.0 and gv > 0.0) or (v >= most_v and gv < 0.0)
    if not (a > 0.0 and a * c - b * b > 1e-9 * a * a):
        a, b, c = max(abs(a), 1.0), 0.0, max(abs(c), 1.0)
    if hold_u or hold_v:
        du, dv = (0.0 if hold_u else -gu / a), (0.0 if hold_v else -gv / c)
    else:
        det = a * c - b * b
        du, dv = (b * gv - c * gu) / det, (b * gu - a * gv) / det
    short = min(1.0, 2.0 / max(math.hypot(du, dv), 1e-300))
    return min(max(u + short * du, 0.0), most_u) - u, min(max(v + short * dv, 0.0), most_v) - v, hold_u, hold_v


@kernel()
def nearest(coefficients: Any, x: Any, y: Any, z: Any, u: Any, v: Any, h: Any) -> Any:
    """Return u, v of the point of the surface that is nearest, from a guess, and which of them the border holds.

    `h` (6,) ends as the spline there.
    """
    most_u, most_v = coefficients.shape[1] - 3.0, coefficients.shape[0] - 3.0
    hold_u = hold_v = False
    spline(coefficients, u, v, h)
    for _ in range(30):
        rise = h[0] - z
        here = (u - x) ** 2 + (v - y) ** 2 + rise * rise
        du, dv, hold_u, hold_v = step(
            u - x + rise * h[1], v - y + rise * h[2],
            1.0 + h[1] * h[1] + rise * h[3], h[1] * h[2] + rise * h[4], 1.0 + h[2] * h[2] + rise * h[5],
            u, v, most_u, most_v,
        )  # fmt: skip
        for _ in range(12):
            spline(coefficients, u + du, v + dv, h)
            close = abs(du) + abs(dv) < _CLOSE
            if close or (u + du - x) ** 2 + (v + dv - y) ** 2 + (h[0] - z) ** 2 <= here:
                break
            du, dv = 0.5 * du, 0.5 * dv
        u, v = u + du, v + dv
        if close:
            break
    return u, v, hold_u, hold_v


@kernel()
def search(nodes: Any, x: Any, y: Any, z: Any, u: Any, v: Any, reach: Any) -> Any:
    """Return the node nearest to (x, y, z) among a few spread within `reach` of (u, v)."""
    best, most = (u, v), np.inf
    stride = max(1, int(2.0 * reach / _SEARCH))
    low_j, high_j = max(0, int(v - reach)), min(nodes.shape[0] - 1, int(v + reach) + 1)
    low_i, high_i = max(0, int(u - reach)), min(nodes.shape[1] - 1, int(u + reach) + 1)
    for j in range(low_j, high_j + 1, stride):
        for i in range(low_i, high_i + 1, stride):
            away = (i - x) ** 2 + (j - y) ** 2 + (nodes[j, i] - z) ** 2
            if away < most:
                best, most = (float(i), float(j)), away
    return best


@kernel()
def on_surface(h: Any, d: Any, normal: Any, curvature: Any) -> Any:
    """Fill normal (3,) and curvature (6,) at a signed distance d off a point with the spline h (6,)."""
    s = math.sqrt(1.0 + h[1] * h[1] + h[2] * h[2])
    normal[0], normal[1], normal[2] = -h[1] / s, -h[2] / s, 1.0 / s
    g11, g12, g22 = 1.0 + h[1] * h[1], h[1] * h[2], 1.0 + h[2] * h[2]
    b11, b12, b22 = h[3] / s, h[4] / s, h[5] / s
    a11, a12, a22 = g11 - d * b11, g12 - d * b12, g22 - d * b22
    det, room = g11 * g22 - g12 * g12, a11 * a22 - a12 * a12
    curvature[:] = 0.0
    if not (a11 > 0.0 and room > 1e-6 * det):  # past a centre of curvature there is no nearest point to speak of
        return
    # w = G^-1 B, m = w A^-1, symmetric
    w11, w12 = (g22 * b11 - g12 * b12) / det, (g22 * b12 - g12 * b22) / det
    w21, w22 = (g11 * b12 - g12 * b11) / det, (g11 * b22 - g12 * b12) / det
    m11, m12 = (w11 * a22 - w12 * a12) / room, (w12 * a11 - w11 * a12) / room
    m22 = (w22 * a11 - w21 * a12) / room
    z1, z2 = m11 * h[1] + m12 * h[2], m12 * h[1] + m22 * h[2]
    curvature[0], curvature[1], curvature[2] = -m11, -m12, -z1
    curvature[3], curvature[4], curvature[5] = -m22, -z2, -(h[1] * z1 + h[2] * z2)


@kernel()
def off_border(away: Any, h: Any, rise: Any, hold_u: Any, hold_v: Any, normal: Any, curvature: Any) -> Any:
    """Fill normal and curvature at a distance `away` from an edge of the border, or from its corner; normal is known."""
    curvature[:] = 0.0
    if away < 1e-9:
        return
    curvature[0] = curvature[3] = curvature[5] = 1.0 / away
    bend(curvature.reshape(1, 6), 0, -1.0 / away, normal[0], normal[1], normal[2])
    if hold_u and hold_v:
        return
    slope, second = (h[2], h[5]) if hold_u else (h[1], h[3])
    share = 1.0 / (away * max(1.0 + slope * slope + rise * second, 1e-3))
    bend(curvature.reshape(1, 6), 0, -share, 0.0 if hold_u else 1.0, 1.0 if hold_u else 0.0, slope)


@kernel()
def beside(x: Any, y: Any, u: Any, v: Any, normal: Any, curvature: Any) -> Any:
    """Fill normal and curvature beside a wall, whose nearest point is over (u, v); return the distance."""
    away = math.hypot(x - u, y - v)
    normal[0], normal[1], normal[2] = (x - u) / away, (y - v) / away, 0.0
    curvature[:] = 0.0
    if x != u and y != v:
        curvature[0] = curvature[3] = 1.0 / away
        bend(curvature.reshape(1, 6), 0, -1.0 / away, normal[0], normal[1], 0.0)
    return away


@kernel()
def within(x: Any, y: Any, most_u: Any, most_v: Any, normal: Any, curvature: Any) -> Any:
    """Fill normal and curvature of the nearest wall, from inside; return the distance, below 0."""
    left, right, near, far = -x, x - most_u, -y, y - most_v
    side, front = max(left, right), max(near, far)
    normal[:] = 0.0
    curvature[:] = 0.0
    if side >= front:
        normal[0] = 1.0 if right >= left else -1.0
    else:
        normal[1] = 1.0 if far >= near else -1.0
    return max(side, front)


@kernel()
def above(x: Any, y: Any, z: Any, coefficients: Any, nodes: Any, winding: Any, u: Any, v: Any, h: Any) -> Any:
    """Return the nearest point u, v of the surface, the distance, and the part that the border holds; h as `nearest`.

    Where the surface is not `winding`, the one found from the point below is taken for it.
    """
    spline(coefficients, u, v, h)
    reach = math.sqrt((z - h[0]) ** 2 + (x - u) ** 2 + (y - v) ** 2)
    first, second, hold_u, hold_v = nearest(coefficients, x, y, z, u, v, h)
    away = math.sqrt((x - first) ** 2 + (y - second) ** 2 + (z - h[0]) ** 2)
    if winding and reach > 1.0:
        third, fourth = search(nodes, x, y, z, u, v, reach)
        other = np.empty(6)
        third, fourth, held_u, held_v = nearest(coefficients, x, y, z, third, fourth, other)
        shorter = math.sqrt((x - third) ** 2 + (y - fourth) ** 2 + (z - other[0]) ** 2)
        if shorter < away:
            h[:] = other
            return third, fourth, shorter, held_u, held_v
    return first, second, away, hold_u, hold_v


@kernel("void(float64[:,::1],float64[:,::1],float64[:,::1],boolean,float64[::1],float64[:,::1],float64[:,::1])")
def ground(points: Any, coefficients: Any, nodes: Any, winding: Any, gap: Any, normal: Any, curvature: Any) -> Any:
    """Fill distance (n,), normal (n, 3) and curvature (n, 6) at points (n, 3) whose x and y are u and v."""
    most_u, most_v = nodes.shape[1] - 1.0, nodes.shape[0] - 1.0
    h = np.empty(6)
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        u, v = min(max(x, 0.0), most_u), min(max(y, 0.0), most_v)
        spline(coefficients, u, v, h)
        below = z <= h[0]
        if below and (x != u or y != v):
            gap[q] = beside(x, y, u, v, normal[q], curvature[q])
            continue
        u, v, away, hold_u, hold_v = above(x, y, z, coefficients, nodes, winding, u, v, h)
        if below and max(max(-x, x - most_u), max(-y, y - most_v)) > -away:
            gap[q] = within(x, y, most_u, most_v, normal[q], curvature[q])
        elif (hold_u or hold_v) and away > 1e-9:
            normal[q, 0], normal[q, 1], normal[q, 2] = (x - u) / away, (y - v) / away, (z - h[0]) / away
            off_border(away, h, h[0] - z, hold_u, hold_v, normal[q], curvature[q])
            gap[q] = away
        else:
            gap[q] = -away if below else away
            on_surface(h, gap[q], normal[q], curvature[q])


@kernel("float64(float64[:,::1],float64[:,::1],float64,float64,float64)")
def highest(coefficients: Any, nodes: Any, rx: Any, ry: Any, rz: Any) -> Any:
    """Return the largest rx u + ry v + rz height; rz is above 0."""
    most_u, most_v = nodes.shape[1] - 1.0, nodes.shape[0] - 1.0
    h = np.empty(6)
    u = v = 0.0
    best = -np.inf
    for j in range(nodes.shape[0]):
        for i in range(nodes.shape[1]):
            value = rx * i + ry * j + rz * nodes[j, i]
            if value > best:
                best, u, v = value, float(i), float(j)
    for _ in range(30):
        spline(coefficients, u, v, h)
        best = max(best, rx * u + ry * v + rz * h[0])
        du, dv, _, _ = step(
            -rx - rz * h[1], -ry - rz * h[2], -rz * h[3], -rz * h[4], -rz * h[5], u, v, most_u, most_v
        )  # fmt: skip
        for _ in range(12):
            spline(coefficients, u + du, v + dv, h)
            if rx * (u + du) + ry * (v + dv) + rz * h[0] >= best:
                break
            du, dv = 0.5 * du, 0.5 * dv
        u, v = u + du, v + dv
        if abs(du) + abs(dv) < 1e-9:
            break
    return best
