"""Signed distance, outward normal and curvature of a closed surface of triangles, compiled; results as of distance_kernel.

The nearest point is searched for in a tree of boxes, its place on a triangle found by the regions of Ericson, Real-Time
Collision Detection (2005), section 5.1.5, and the sign by angle-weighted normals (Baerentzen and Aanaes, IEEE TVCG 11:243,
2005).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.simulation.membrane.indenters.distance_kernel import bend

__all__ = ["rounded"]


@kernel()
def nearest(p: Any, corners: Any) -> Any:
    """Return the feature of a triangle (3, 3) that is nearest to a point, and the shares of the edges ab and ac to it.

    0 is the face, 1 to 3 the edges from corner a, b and c to the next one, 4 to 6 the corners.
    """
    d1 = d2 = aa = ac = cc = 0.0
    for k in range(3):
        u, v, w = corners[1, k] - corners[0, k], corners[2, k] - corners[0, k], p[k] - corners[0, k]
        d1, d2, aa, ac, cc = d1 + u * w, d2 + v * w, aa + u * u, ac + u * v, cc + v * v
    d3, d4, d5, d6 = d1 - aa, d2 - ac, d1 - ac, d2 - cc
    if d1 <= 0.0 and d2 <= 0.0:
        return 4, 0.0, 0.0
    if d3 >= 0.0 and d4 <= d3:
        return 5, 1.0, 0.0
    if d6 >= 0.0 and d5 <= d6:
        return 6, 0.0, 1.0
    to_a, to_b, to_c = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if to_c <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return 1, d1 / aa, 0.0
    if to_b <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return 3, 0.0, d2 / cc
    if to_a <= 0.0 and d4 >= d3 and d5 >= d6:
        share = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 2, 1.0 - share, share
    whole = 1.0 / (to_a + to_b + to_c)
    return 0, to_b * whole, to_c * whole


@kernel()
def outside(p: Any, box: Any) -> Any:
    """Return the squared distance of a point (3,) from a box (6,): lows, then highs."""
    square = 0.0
    for k in range(3):
        off = max(max(box[k] - p[k], p[k] - box[3 + k]), 0.0)
        square += off * off
    return square


@kernel()
def search(p: Any, corners: Any, boxes: Any, links: Any, stack: Any, foot: Any, limit: Any) -> Any:
    """Fill foot (3,), the nearest point of all triangles; return triangle, feature and squared distance.

    A box with links (first, last, 0) holds those triangles, one with (left, right, 1) two smaller boxes. The squared distance is
    known to be below `limit`.
    """
    best, triangle, feature, depth = limit, 0, 0, 1
    stack[0] = 0
    while depth > 0:
        depth -= 1
        node = stack[depth]
        if outside(p, boxes[node]) >= best:
            continue
        first, last, inner = links[node, 0], links[node, 1], links[node, 2]
        if inner:
            nearer = outside(p, boxes[first]) < outside(p, boxes[last])
            stack[depth], stack[depth + 1] = (last, first) if nearer else (first, last)
            depth += 2
            continue
        for t in range(first, last):
            found, v, w = nearest(p, corners[t])
            square = 0.0
            for k in range(3):
                square += (p[k] - (1.0 - v - w) * corners[t, 0, k] - v * corners[t, 1, k] - w * corners[t, 2, k]) ** 2
            if square < best:
                best, triangle, feature = square, t, found
                for k in range(3):
                    foot[k] = (1.0 - v - w) * corners[t, 0, k] + v * corners[t, 1, k] + w * corners[t, 2, k]
    return triangle, feature, best


@kernel(
    "void(float64[:,::1],float64[:,:,::1],float64[:,:,::1],float64[:,::1],int64[:,::1],float64,"
    "float64[::1],float64[:,::1],float64[:,::1])"
)
def rounded(
    points: Any,
    corners: Any,
    normals: Any,
    boxes: Any,
    links: Any,
    rounding: Any,
    gap: Any,
    normal: Any,
    curvature: Any,
) -> Any:
    """Fill for a surface of triangles `corners` (m, 3, 3), rounded; `normals` (m, 7, 3) are the normals of their features."""
    curvature[:] = 0.0
    stack, foot, away = np.empty(128, np.int64), np.empty(3), np.inf
    for q in range(points.shape[0]):
        if q > 0:  # the distance changes by no more than the point moves
            x, y, z = points[q, 0] - points[q - 1, 0], points[q, 1] - points[q - 1, 1], points[q, 2] - points[q - 1, 2]
            away += 1e-9 + 1.001 * math.sqrt(x * x + y * y + z * z)
        t, feature, square = search(points[q], corners, boxes, links, stack, foot, away * away)
        away, facing = math.sqrt(square), normals[t, feature]
        x, y, z = points[q, 0] - foot[0], points[q, 1] - foot[1], points[q, 2] - foot[2]
        signed = away if x * facing[0] + y * facing[1] + z * facing[2] >= 0.0 else -away
        gap[q] = signed - rounding
        if away < 1e-9 * rounding or feature == 0:
            normal[q] = facing
            continue
        s = 1.0 / signed
        x, y, z = s * x, s * y, s * z
        normal[q, 0], normal[q, 1], normal[q, 2] = x, y, z
        curvature[q, 0] = curvature[q, 3] = curvature[q, 5] = s
        bend(curvature, q, -s, x, y, z)
        if feature <= 3:
            a, b = corners[t, feature - 1], corners[t, feature % 3]
            x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
            bend(curvature, q, -s / (x * x + y * y + z * z), x, y, z)
