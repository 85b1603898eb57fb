"""Passes over the pixels or bins of a frame, compiled: each does at once what takes numpy many temporary images.

Points come as rows of x, y, z after one another, (h, 3 w). Rows are taken out before the inner loops, which have no branch:
that is what compiles to vector instructions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = [
    "fill_along",
    "fill_bending",
    "fill_height",
    "fill_moves",
    "fill_points",
    "fill_surface",
    "fill_weighted",
    "halve",
]

ZERO, HALF, ONE, TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)
QUARTER, LEAST = np.float32(0.25), np.float32(1e-3)


@kernel(
    [
        "void(float32[:,::1],boolean[:,::1],float32[:,::1],float32[:,::1],float32,float32,float32,float32[:,::1])",
        "void(float64[:,::1],boolean[:,::1],float64[:,::1],float64[:,::1],float64,float64,float64,float64[:,::1])",
    ]
)
def fill_points(depth: Any, valid: Any, x: Any, y: Any, sign: Any, offset: Any, nan: Any, points: Any) -> None:
    """Fill points from a depth image (h, w) and its ray table; z is sign * depth + offset, and all `nan` where invalid."""
    for v in range(depth.shape[0]):
        image, seen, along, down, row = depth[v], valid[v], x[v], y[v], points[v]
        for u in range(depth.shape[1]):
            z = image[u] if seen[u] else nan
            row[3 * u] = along[u] * z
            row[3 * u + 1] = down[u] * z
            row[3 * u + 2] = sign * z + offset


@kernel(
    [
        "void(float32[:,::1],boolean[:,:],int64,int64,float64,float32,float32[:,::1])",
        "void(float64[:,::1],boolean[:,:],int64,int64,float64,float32,float32[:,::1])",
    ]
)
def fill_height(points: Any, valid: Any, v0: Any, u0: Any, level: Any, sign: Any, height: Any) -> None:
    """Fill the height (h, w) above a level of the points from row v0 and column u0 on; 0 where invalid."""
    for v in range(height.shape[0]):
        row, seen, found = points[v0 + v, 3 * u0 :], valid[v], height[v]
        for u in range(height.shape[1]):
            z = sign * np.float32(row[3 * u + 2] - level)
            found[u] = z if seen[u] else ZERO


@kernel(
    [
        "void(float32[:,::1],boolean[:,::1],float32[:,::1],float32[:,::1])",
        "void(float32[:,::1],float32[:,::1],float32[:,::1],float32[:,::1])",
    ]
)
def halve(image: Any, weight: Any, mean: Any, share: Any) -> None:
    """Fill the weighted mean and the mean weight of each 2 x 2 pixels; those beyond the image weigh 0."""
    h, w = image.shape
    total, count = np.zeros(w + w % 2, dtype=np.float32), np.zeros(w + w % 2, dtype=np.float32)
    for v in range(mean.shape[0]):
        below = min(2 * v + 1, h - 1)
        upper, lower, first, second = image[2 * v], image[below], weight[2 * v], weight[below]
        twice = np.float32(below - 2 * v)
        for u in range(w):
            p, q = np.float32(first[u]), np.float32(second[u]) * twice
            total[u] = p * upper[u] + q * lower[u]
            count[u] = p + q
        found, part = mean[v], share[v]
        for u in range(mean.shape[1]):
            both = count[2 * u] + count[2 * u + 1]
            found[u] = (total[2 * u] + total[2 * u + 1]) / max(both, LEAST)
            part[u] = QUARTER * both


@kernel(
    "void(float32[:,::1],float32[:,::1],float32[:,::1],float32[:,::1],float32,float32,"
    "float32[:,::1],boolean[:,::1],boolean[:,::1])"
)
def fill_surface(
    total: Any, cover: Any, raw: Any, share: Any, least: Any, steepest: Any, height: Any, valid: Any, trusted: Any
) -> None:
    """Turn `total` into the mean, and fill the height, its holes with the mean, what is valid and what can be trusted.

    Trusted is what is covered by more than `least`, with a slope of the cover of less than `steepest` per bin; the outermost
    bins never are, for half of what is around them is not seen.
    """
    h, w = total.shape
    for v in range(h):
        mean, seen, bins, part, found, known = total[v], cover[v], raw[v], share[v], height[v], valid[v]
        for u in range(w):
            mean[u] = mean[u] / max(seen[u], LEAST)
            known[u] = part[u] > ZERO
            found[u] = bins[u] if part[u] > ZERO else mean[u]
    trusted[:] = False
    for v in range(1, h - 1):
        above, seen, below, sure = cover[v - 1], cover[v], cover[v + 1], trusted[v]
        for u in range(1, w - 1):
            slope = HALF * max(abs(seen[u + 1] - seen[u - 1]), abs(below[u] - above[u]))
            sure[u] = (seen[u] > least) & (slope < steepest)


@kernel(
    [
        "void(float32[:,::1],boolean[:,:],int64,int64,int64,float32,float32[:,::1],float32[:,::1])",
        "void(float64[:,::1],boolean[:,:],int64,int64,int64,float32,float32[:,::1],float32[:,::1])",
    ]
)
def fill_moves(points: Any, valid: Any, v0: Any, u0: Any, every: Any, pitch: Any, x: Any, y: Any) -> None:
    """Fill x and y (h, w) of every so many points, less even steps of `pitch`; holes take the mean of what is near."""
    h, w = x.shape
    holes = 0
    for n in range(h):
        for m in range(w):
            x[n, m], y[n, m] = 0.0, 0.0
            if valid[n * every, m * every]:
                row, at = v0 + n * every, 3 * (u0 + m * every)
                x[n, m], y[n, m] = points[row, at] - m * pitch, points[row, at + 1] - n * pitch
            else:
                holes += 1
    if not holes:
        return
    counts = np.zeros((h + 1, w + 1), dtype=np.int64)
    xs, ys = np.zeros((h + 1, w + 1)), np.zeros((h + 1, w + 1))
    for n in range(h):
        count, along, down = 0, 0.0, 0.0
        for m in range(w):
            if valid[n * every, m * every]:
                row, at = v0 + n * every, 3 * (u0 + m * every)
                count += 1
                along, down = along + (points[row, at] - m * pitch), down + (points[row, at + 1] - n * pitch)
            counts[n + 1, m + 1] = counts[n, m + 1] + count
            xs[n + 1, m + 1], ys[n + 1, m + 1] = xs[n, m + 1] + along, ys[n, m + 1] + down
    # A sum over any square is that of four corners, so that a hole costs no more the larger it is.
    for v in range(h):
        for u in range(w):
            reach = max(h, w) if valid[v * every, u * every] else 2
            while reach < max(h, w):
                a, b = max(v - reach, 0), min(v + reach + 1, h)
                c, d = max(u - reach, 0), min(u + reach + 1, w)
                count = counts[b, d] - counts[a, d] - counts[b, c] + counts[a, c]
                if count > 0:
                    x[v, u] = (xs[b, d] - xs[a, d] - xs[b, c] + xs[a, c]) / count
                    y[v, u] = (ys[b, d] - ys[a, d] - ys[b, c] + ys[a, c]) / count
                    break
                reach = 2 * reach + 1


@kernel(
    "void(float32[:,::1],float32[:,::1],int64,int64,float32,float32[:,::1],float32[:,::1],float32[:,::1],float32[:,::1])"
)
def fill_bending(smooth: Any, moves: Any, v0: Any, u0: Any, share: Any, x: Any, y: Any, xx: Any, yy: Any) -> None:
    """Fill slopes and second derivatives (h, w) from a smooth height (h + 2, w + 2), whose outermost bins are copies.

    `moves` holds, from row v0 and bin u0 on, how far x and y move in 1 / `share` bins, m, and how fast that changes.
    Perspective makes it change where the surface rises; left out, a steep flank gains a false curvature.
    """
    back, square = ONE / share, share * share
    h, w = x.shape
    for v in range(h):
        above, here, below, step = smooth[v], smooth[v + 1], smooth[v + 2], moves[v0 + v, 4 * u0 :]
        x_row, y_row, xx_row, yy_row = x[v], y[v], xx[v], yy[v]
        for u in range(w):
            x_u, y_v = back / step[4 * u], back / step[4 * u + 1]
            slope_x = HALF * (here[u + 2] - here[u]) * x_u
            slope_y = HALF * (below[u + 1] - above[u + 1]) * y_v
            twice = TWO * here[u + 1]
            x_row[u], y_row[u] = slope_x, slope_y
            xx_row[u] = (here[u + 2] - twice + here[u] - square * slope_x * step[4 * u + 2]) * (x_u * x_u)
            yy_row[u] = (below[u + 1] - twice + above[u + 1] - square * slope_y * step[4 * u + 3]) * (y_v * y_v)


@kernel("void(float32[:,::1],float32[:,::1],float32[:,::1],float32[:,::1],boolean[:,:],float32,float32[:,::1])")
def fill_weighted(x: Any, y: Any, xx: Any, yy: Any, trusted: Any, k: Any, curvature: Any) -> None:
    """Fill -(xx + k yy) / ((1 + x^2 + k (1 + y^2)) sqrt(1 + x^2 + y^2)), 0 where it cannot be trusted."""
    for v in range(x.shape[0]):
        a, b, c, d, sure, found = x[v], y[v], xx[v], yy[v], trusted[v], curvature[v]
        for u in range(x.shape[1]):
            p, q = a[u] * a[u], b[u] * b[u]
            bent = -(c[u] + k * d[u]) / ((ONE + p + k * (ONE + q)) * np.sqrt(ONE + p + q))
            found[u] = bent if sure[u] else ZERO


@kernel(
    "void(float32[:,::1],float32[:,::1],float32[:,::1],float32[:,::1],boolean[:,:],float32[:,::1],float32[:,::1])",
)
def fill_along(x: Any, y: Any, xx: Any, yy: Any, trusted: Any, i: Any, j: Any) -> None:
    """Fill the normal curvatures along both axes, -xx / ((1 + x^2) sqrt(1 + x^2 + y^2)) and alike, 0 where they cannot be trusted."""
    for v in range(x.shape[0]):
        a, b, c, d, sure, along_i, along_j = x[v], y[v], xx[v], yy[v], trusted[v], i[v], j[v]
        for u in range(x.shape[1]):
            p, q = ONE + a[u] * a[u], ONE + b[u] * b[u]
            root = np.sqrt(p + b[u] * b[u])
            bent_i, bent_j = -c[u] / (p * root), -d[u] / (q * root)
            along_i[u] = bent_i if sure[u] else ZERO
            along_j[u] = bent_j if sure[u] else ZERO
