"""Depth of a surface that hides nothing of itself, compiled: two passes of cubics over the maps of its grid.

The grid's points are given as the columns, rows and depths of the pixels that see them. The first pass finds where each row
of the grid crosses each column of the image, the second follows these crossings down the column: two inversions of one
variable instead of one of two. Slopes are central differences of fourth order, so that depth is good to the fourth order of
the grid's pitch and has no facets. The maps reach beyond the surface, by two rows at each end, for the slopes, and by three
columns on each side: the first pass goes one column beyond, which shows the second where between two rows it ends.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["look"]

_STEPS = 4
_CLOSE = 1e-7  # pixels


@kernel()
def slope(a: Any, b: Any, d: Any, e: Any) -> Any:
    """Return the slope at the middle of five even samples, the middle left out (Fornberg 1988, fourth order)."""
    return (8.0 * (d - b) - (e - a)) / 12.0


@kernel()
def cubic(a: Any, b: Any, m: Any, n: Any, s: Any) -> Any:
    """Return the cubic with the values a, b and slopes m, n at 0 and 1, at s."""
    d = b - a
    return a + s * (m + s * (3.0 * d - 2.0 * m - n + s * (m + n - 2.0 * d)))


@kernel()
def crossing(a: Any, b: Any, m: Any, n: Any, level: Any) -> Any:
    """Return where in 0 to 1 that cubic is at a level between a and b, by Newton's method kept inside."""
    d = b - a
    c2, c3 = 3.0 * d - 2.0 * m - n, m + n - 2.0 * d
    s = (level - a) / d
    for _ in range(_STEPS):
        off = a + s * (m + s * (c2 + s * c3)) - level
        if abs(off) < _CLOSE:
            break
        rate = m + s * (2.0 * c2 + 3.0 * s * c3)
        s = min(max(s - off / (rate if abs(rate) > 0.1 * abs(d) else d), 0.0), 1.0)
    return s


@kernel()
def cross_rows(column: Any, row: Any, depth: Any, v: Any, z: Any, place: Any) -> Any:
    """Fill row v, depth z and place along the grid where its rows (r,) cross the image's columns (r, w); else NaN.

    Returns whether every row crosses each column once at most.
    """
    width = v.shape[1]
    for j in range(column.shape[0]):
        c, r, d = column[j], row[j], depth[j]
        v[j, :], z[j, :], place[j, :] = np.nan, np.nan, np.nan
        for i in range(2, len(c) - 3):
            if not c[i + 1] > c[i]:
                return False
            first, last = max(math.ceil(c[i]), 0.0), min(math.floor(c[i + 1]), width - 1.0)
            if first > last:
                continue
            m, n = slope(c[i - 2], c[i - 1], c[i + 1], c[i + 2]), slope(c[i - 1], c[i], c[i + 2], c[i + 3])
            rm, rn = slope(r[i - 2], r[i - 1], r[i + 1], r[i + 2]), slope(r[i - 1], r[i], r[i + 2], r[i + 3])
            dm, dn = slope(d[i - 2], d[i - 1], d[i + 1], d[i + 2]), slope(d[i - 1], d[i], d[i + 2], d[i + 3])
            for u in range(int(first), int(last) + 1):
                s = crossing(c[i], c[i + 1], m, n, u)
                v[j, u] = cubic(r[i], r[i + 1], rm, rn, s)
                z[j, u] = cubic(d[i], d[i + 1], dm, dn, s)
                place[j, u] = i - 3 + s
    return True


@kernel()
def slopes(values: Any, out: Any) -> Any:
    """Fill slopes from row to row (r, w): of fourth order where five rows are known, else of second or first; else NaN."""
    rows, width = values.shape
    for j in range(2, rows - 2):
        a, b, c, d, e = values[j - 2], values[j - 1], values[j], values[j + 1], values[j + 2]
        for u in range(width):
            found = (8.0 * (d[u] - b[u]) - (e[u] - a[u])) / 12.0
            if math.isnan(found):
                found = 0.5 * (d[u] - b[u])
                if math.isnan(found):
                    found = c[u] - b[u] if math.isnan(d[u]) else d[u] - c[u]
            out[j, u] = found


@kernel("boolean(float64[:,::1],float64[:,::1],float64[:,::1],float64[:,:,::1],float32[:,::1])")
def look(column: Any, row: Any, depth: Any, work: Any, image: Any) -> Any:
    """Fill the image (h, w), m, where it sees the surface, from the maps (r, c); work is (5, r, w).

    Returns False, with the image half done, where the surface hides a part of itself.
    """
    v, z, place, dv, dz = work[0], work[1], work[2], work[3], work[4]
    if not cross_rows(column, row, depth, v, z, place):
        return False
    slopes(v, dv)
    slopes(z, dz)
    rows, width, most = column.shape[0], image.shape[1], column.shape[1] - 7.0
    height = image.shape[0]
    for j in range(2, rows - 3):
        for u in range(width):
            a, b = v[j, u], v[j + 1, u]
            if math.isnan(a) or math.isnan(b):
                continue
            if not b > a:
                return False
            p, q = place[j, u], place[j + 1, u]
            whole = p >= 0.0 and q >= 0.0 and p <= most and q <= most
            for w in range(max(math.ceil(a), 0), min(math.floor(b), height - 1) + 1):
                t = crossing(a, b, dv[j, u], dv[j + 1, u], w)
                if whole or 0.0 <= p + t * (q - p) <= most:
                    image[w, u] = cubic(z[j, u], z[j + 1, u], dz[j, u], dz[j + 1, u], t)
    return True
