"""The upper side of a lump over a grid, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["top_side"]

_AROUND, _DOWN = 48, 20
_WIDTH = 2.0  # how far a radius counts, over the spacing of directions
_HALVINGS = 40


@kernel("float64[:,::1](float64[::1], float64[:,::1], float64)")
def table(radii: Any, vectors: Any, steepest: Any) -> Any:
    """Return radii at polar angles from 0 to `steepest`, rad, and azimuths all round: means of the radii close by."""
    found = np.empty((_DOWN + 1, _AROUND))
    near = math.cos(min(_WIDTH * math.sqrt(4.0 * math.pi / len(radii)), 1.0))
    for i in range(_DOWN + 1):
        polar = steepest * i / _DOWN
        for j in range(_AROUND):
            azimuth = 2.0 * math.pi * j / _AROUND
            x, y, z = math.sin(polar) * math.cos(azimuth), math.sin(polar) * math.sin(azimuth), math.cos(polar)
            total, sum_of_weights = 0.0, 0.0
            for k in range(len(radii)):
                over = vectors[k, 0] * x + vectors[k, 1] * y + vectors[k, 2] * z - near
                if over > 0.0:
                    total += over * over * radii[k]
                    sum_of_weights += over * over
            found[i, j] = total / sum_of_weights
    return found


@kernel("float64(float64[:,::1], float64, float64, float64)")
def radius_at(found: Any, polar: Any, azimuth: Any, steepest: Any) -> Any:
    """Return the radius between the places of a table, linear in both angles."""
    row = min(polar / steepest * _DOWN, _DOWN - 1e-9)
    column = azimuth / (2.0 * math.pi) * _AROUND
    i, j = int(row), int(column)
    s, t = row - i, column - j
    j, k = j % _AROUND, (j + 1) % _AROUND
    return (1 - s) * ((1 - t) * found[i, j] + t * found[i, k]) + s * ((1 - t) * found[i + 1, j] + t * found[i + 1, k])


@kernel("float64[:,::1](float64[::1], float64[:,::1], float64, int64, float64)")
def top_side(radii: Any, vectors: Any, pitch: Any, count: Any, steepest: Any) -> Any:
    """Return heights (count, count), m, over the centroid on a square grid around it; directions (n, 3) in world axes.

    Past the polar angle `steepest`, rad, the surface goes on downwards as a cone of that slope.
    """
    found = table(radii, vectors, steepest)
    heights = np.empty((count, count))
    for row in range(count):
        for column in range(count):
            x, y = (column - 0.5 * (count - 1)) * pitch, (row - 0.5 * (count - 1)) * pitch
            away, azimuth = math.sqrt(x * x + y * y), math.atan2(y, x) % (2.0 * math.pi)
            edge = radius_at(found, steepest, azimuth, steepest)
            if away >= edge * math.sin(steepest):
                beyond = away - edge * math.sin(steepest)
                heights[row, column] = edge * math.cos(steepest) - beyond * math.tan(steepest)
                continue
            least, most = 0.0, steepest
            for _ in range(_HALVINGS):
                polar = 0.5 * (least + most)
                if radius_at(found, polar, azimuth, steepest) * math.sin(polar) < away:
                    least = polar
                else:
                    most = polar
            heights[row, column] = radius_at(found, least, azimuth, steepest) * math.cos(least)
    return heights
