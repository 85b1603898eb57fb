"""Depth of a surface that hides parts of itself, compiled: triangles with a depth buffer say which part a pixel sees, and a
few steps on cubics through the grid, with the slopes of the triangle, take the facets out.
"""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["look_through"]

_STEPS = 8
_NEAR = 0.03  # of a cell; the step after it would be a few hundredths of it
_FAR = 0.5  # of a cell; a ray that leads farther away grazes a fold, and the facet stays


@kernel()
def weights(t: Any) -> Any:
    """Return the values at t, 0 to 1, of the four cubics that interpolate between the middle two of four samples.

    Their slopes at the ends are central differences (Catmull and Rom 1974).
    """
    s = 1.0 - t
    return -0.5 * t * s * s, 1.0 + t * t * (1.5 * t - 2.5), 1.0 + s * s * (1.5 * s - 2.5), -0.5 * s * t * t


@kernel()
def line(values: Any, i: Any, j: Any, x: Any) -> Any:
    """Return the cubic between columns i and i + 1 of row j, from its weights."""
    return x[0] * values[j, i - 1] + x[1] * values[j, i] + x[2] * values[j, i + 1] + x[3] * values[j, i + 2]


@kernel()
def patch(values: Any, i: Any, j: Any, x: Any, y: Any) -> Any:
    """Return the bicubic over the cell at column i, row j, from the weights along both."""
    above = y[0] * line(values, i, j - 1, x) + y[1] * line(values, i, j, x)
    return above + y[2] * line(values, i, j + 1, x) + y[3] * line(values, i, j + 2, x)


@kernel()
def refined(
    column: Any, row: Any, depth: Any, i: Any, j: Any, u: Any, v: Any, s: Any, t: Any, slopes: Any, facet: Any
) -> Any:
    """Return the depth at which the ray of pixel (u, v) meets the bicubic near (s, t) of a cell, or the facet's.

    `slopes` are the derivatives of s and t by u and v on the facet.
    """
    su, sv, tu, tv = slopes
    s0, t0 = s, t
    for _ in range(_STEPS):
        x, y = weights(s), weights(t)
        off_u, off_v = u - patch(column, i, j, x, y), v - patch(row, i, j, x, y)
        ds, dt = su * off_u + sv * off_v, tu * off_u + tv * off_v
        s, t = s + ds, t + dt
        if not (abs(s - s0) < _FAR and abs(t - t0) < _FAR):
            return facet
        if abs(ds) + abs(dt) < _NEAR:
            return patch(depth, i, j, weights(s), weights(t))
    return facet


@kernel()
def corner(column: Any, row: Any, i: Any, j: Any) -> Any:
    """Return the pixel that sees a point of the grid."""
    return column[j, i], row[j, i]


@kernel()
def triangle(column: Any, row: Any, depth: Any, i: Any, j: Any, upper: Any, image: Any) -> Any:
    """Draw half of a cell into the image (h, w) wherever it is nearer than the depth there; 0 is none."""
    o = 1 if upper else 0  # the corner (o, o) and its two neighbours; places in the cell count from there
    sign = 1.0 - 2.0 * o
    cu, cv = corner(column, row, i + o, j + o)
    au, av = corner(column, row, i + 1 - o, j + o)
    bu, bv = corner(column, row, i + o, j + 1 - o)
    area = (au - cu) * (bv - cv) - (bu - cu) * (av - cv)
    height, width = image.shape
    if abs(area) < 1e-12 or not abs(area) < 1e12:
        return
    # Negated where the cell's own s and t count the other way.
    su, sv, tu, tv = (bv - cv) / area, (cu - bu) / area, (cv - av) / area, (au - cu) / area
    slopes = sign * su, sign * sv, sign * tu, sign * tv
    z0, zs, zt = depth[j + o, i + o], depth[j + o, i + 1 - o], depth[j + 1 - o, i + o]
    first, last = max(math.ceil(min(cu, au, bu)), 0), min(math.floor(max(cu, au, bu)), width - 1)
    for v in range(max(math.ceil(min(cv, av, bv)), 0), min(math.floor(max(cv, av, bv)), height - 1) + 1):
        for u in range(first, last + 1):
            s, t = su * (u - cu) + sv * (v - cv), tu * (u - cu) + tv * (v - cv)
            if s < -1e-9 or t < -1e-9 or s + t > 1.0 + 1e-9:
                continue
            z = z0 + s * (zs - z0) + t * (zt - z0)
            z = refined(column, row, depth, i, j, u, v, o + sign * s, o + sign * t, slopes, z)
            if image[v, u] == 0.0 or z < image[v, u]:
                image[v, u] = z


@kernel("void(float64[:,::1],float64[:,::1],float64[:,::1],int64,int64,float32[:,::1])")
def look_through(column: Any, row: Any, depth: Any, rows: Any, columns: Any, image: Any) -> Any:
    """Fill the image (h, w), m, 0 before, with the nearest of the surface.

    The maps (r, c) reach beyond the surface by that many rows at each end and columns on each side, at least 1.
    """
    for j in range(rows, column.shape[0] - rows - 1):
        for i in range(columns, column.shape[1] - columns - 1):
            triangle(column, row, depth, i, j, False, image)
            triangle(column, row, depth, i, j, True, image)
