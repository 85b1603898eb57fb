"""Means of square blocks of pixels around a place, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["blocks_within", "fill_within", "squares_of"]

SPARSE = 4  # pixels in rows and columns between those that are looked at to find the others
CLEAR = 8  # of these that tell its extent; where fewer are met, all are looked at
COVER = 0.5  # share of a block that must be seen


@kernel([f"float64[:,::1]({kind}[:,:,:],float64,float64,float64,float64,int64)" for kind in ("float32", "float64")])
def blocks_within(surface: Any, x: Any, y: Any, a: Any, b: Any, most: Any) -> Any:
    """Return the means, and how many pixels, (m, 4), of blocks of pixels in an ellipse about (x, y) of semi-axes a and b.

    The surface is (h, w, 3), NaN where invalid. Blocks are squares as small as `most` of them allow.
    """
    height, width = surface.shape[0], surface.shape[1]
    every, count = 2 * SPARSE, 0
    while count < CLEAR and every > 1:
        every = SPARSE if every > SPARSE else 1
        top, bottom, left, right, count = height, -1, width, -1, 0
        for v in range(0, height, every):
            for u in range(0, width, every):
                dx, dy = (surface[v, u, 0] - x) / a, (surface[v, u, 1] - y) / b
                if dx * dx + dy * dy < 1.0:
                    top, bottom, left, right = min(top, v), v, min(left, u), max(right, u)
                    count += 1
    if count == 0:
        return np.empty((0, 4))
    top, left = max(top - every + 1, 0), max(left - every + 1, 0)
    bottom, right = min(bottom + every, height), min(right + every, width)
    side = max(1, round((count * every**2 / most) ** 0.5))
    rows, columns = -(-(bottom - top) // side), -(-(right - left) // side)
    means, found = np.empty((rows * columns, 4)), 0
    for v in range(top, bottom, side):
        for u in range(left, right, side):
            sx, sy, sz, seen = 0.0, 0.0, 0.0, 0
            for i in range(v, min(v + side, bottom)):
                for j in range(u, min(u + side, right)):
                    px, py, pz = (
                        np.float64(surface[i, j, 0]),
                        np.float64(surface[i, j, 1]),
                        np.float64(surface[i, j, 2]),
                    )
                    dx, dy = (px - x) / a, (py - y) / b
                    if dx * dx + dy * dy < 1.0 and np.isfinite(pz):
                        sx, sy, sz, seen = sx + px, sy + py, sz + pz, seen + 1
            if seen >= COVER * side * side:
                means[found, 0], means[found, 1], means[found, 2] = sx / seen, sy / seen, sz / seen
                means[found, 3] = seen
                found += 1
    return means[:found].copy()


@kernel([f"void({kind}[:,:,:],{kind},{kind},{kind},{kind},boolean[:,::1])" for kind in ("float32", "float64")])
def fill_within(surface: Any, x: Any, y: Any, a: Any, b: Any, within: Any) -> None:
    """Fill which pixels (h, w) of a surface (h, w, 3) lie in an ellipse about (x, y) of semi-axes a and b."""
    for v in range(within.shape[0]):
        for u in range(within.shape[1]):
            dx, dy = (surface[v, u, 0] - x) / a, (surface[v, u, 1] - y) / b
            within[v, u] = dx * dx + dy * dy < 1.0


@kernel([f"float64[:,:,::1]({kind}[:,:,:],int64)" for kind in ("float32", "float64")])
def squares_of(surface: Any, side: Any) -> Any:
    """Return means of x, y and z, and how many pixels are seen, (rows, columns, 4), of squares of a surface (h, w, 3); 0 where none is."""
    rows, columns = surface.shape[0] // side, surface.shape[1] // side
    means = np.zeros((rows, columns, 4))
    for v in range(rows * side):
        row = means[v // side]
        for u in range(columns * side):
            z = np.float64(surface[v, u, 2])
            if np.isfinite(z):
                square = row[u // side]
                square[0] += surface[v, u, 0]
                square[1] += surface[v, u, 1]
                square[2] += z
                square[3] += 1.0
    for v in range(rows):
        for u in range(columns):
            for k in range(3):
                means[v, u, k] /= max(means[v, u, 3], 1.0)
    return means
