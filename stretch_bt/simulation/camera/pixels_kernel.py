"""A camera's errors in single pixels, compiled. Depths are (h, w) float32, m, 0 where there is no value, changed in place."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["add", "drop", "fly"]

ZERO, LEAST = np.float32(0.0), np.float32(1e-6)


@kernel("void(float32[:,::1],float32[:,::1],float32,float32)")
def add(depth: Any, noise: Any, sd: Any, growth: Any) -> Any:
    """Add noise times sd + growth depth^2 to the pixels that have a value; none goes behind the camera.

    Computed in double precision, so that processors with and without fused multiplication round the pixel alike.
    """
    for v in range(depth.shape[0]):
        row, more = depth[v], noise[v]
        for u in range(depth.shape[1]):
            z = float(row[u])
            row[u] = (
                max(np.float32(z + float(more[u]) * (float(sd) + float(growth) * z * z)), LEAST) if z > ZERO else ZERO
            )


@kernel()
def is_steep(depth: Any, v: Any, u: Any, fx: Any, fy: Any, cx: Any, cy: Any, least: Any) -> Any:
    """Return whether the cosine between a pixel's ray and the surface's normal is below `least`, by neighbours with a value.

    With n = (fx z_u, fy z_v, -z - (u - cx) z_u - (v - cy) z_v) along the normal of z(u, v), and r the ray at unit depth,
    n . r = -z.
    """
    height, width = depth.shape
    z = depth[v, u]
    left = u - 1 if u > 0 and depth[v, u - 1] > ZERO else u
    right = u + 1 if u + 1 < width and depth[v, u + 1] > ZERO else u
    over = v - 1 if v > 0 and depth[v - 1, u] > ZERO else v
    under = v + 1 if v + 1 < height and depth[v + 1, u] > ZERO else v
    across = (depth[v, right] - depth[v, left]) / max(right - left, 1)
    along = (depth[under, u] - depth[over, u]) / max(under - over, 1)
    x, y = u - cx, v - cy
    normal = (fx * across) ** 2 + (fy * along) ** 2 + (z + x * across + y * along) ** 2
    return z < least * math.sqrt(normal * ((x / fx) ** 2 + (y / fy) ** 2 + 1.0))


@kernel("void(float32[:,::1],int64[::1],float32[::1],float64,float64,float64,float64,float64,float64)")
def drop(depth: Any, places: Any, drawn: Any, keep: Any, fx: Any, fy: Any, cx: Any, cy: Any, least: Any) -> Any:
    """Take the value of pixels, numbered row by row, but of those drawn at `keep` or over that are not steep."""
    lost = np.zeros(len(places), np.bool_)
    width = depth.shape[1]
    for k in range(len(places)):
        v, u = divmod(places[k], width)
        lost[k] = drawn[k] < keep or is_steep(depth, v, u, fx, fy, cx, cy, least)
    for k in range(len(places)):
        if lost[k]:
            depth[places[k] // width, places[k] % width] = ZERO


@kernel()
def step(depth: Any, v: Any, u: Any) -> Any:
    """Return the largest step of depth from a pixel with a value to a neighbour with one."""
    largest = 0.0
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        j, i = v + down, u + right
        if 0 <= j < depth.shape[0] and 0 <= i < depth.shape[1] and depth[j, i] > ZERO:
            there = depth[j, i] - depth[v, u]
            if abs(there) > abs(largest):
                largest = there
    return largest


@kernel("void(float32[:,::1],int64[::1],float64[::1],float64)")
def fly(depth: Any, places: Any, far: Any, least: Any) -> Any:
    """Move pixels, numbered row by row, that are beside a step of more than `least` towards its other side, at most to it."""
    width = depth.shape[1]
    moved = np.zeros(len(places))
    for k in range(len(places)):
        v, u = divmod(places[k], width)
        if depth[v, u] > ZERO:
            there = step(depth, v, u)
            if abs(there) > least:
                moved[k] = math.copysign(min(far[k], abs(there)), there)
    for k in range(len(places)):
        depth[places[k] // width, places[k] % width] += np.float32(moved[k])
