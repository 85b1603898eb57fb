"""Where the middle of a lump is: its volume and centroid, and its radii measured from there, compiled.

The lump is the star-shaped body |p| <= r(d), r (n,) on directions d (n, 3) of equal solid angle w.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["SMALLEST", "centre", "rescale", "shift", "volume"]

SMALLEST = 0.05  # least radius over the mean radius, whatever is asked


@kernel("float64(float64[::1], float64)")
def volume(radii: Any, w: Any) -> Any:
    """Return the volume of the lump, m^3."""
    total = 0.0
    for r in radii:
        total += r * r * r
    return total * w / 3.0


@kernel("float64(float64[::1], float64, float64)")
def rescale(radii: Any, w: Any, content: Any) -> Any:
    """Scale the lump to a volume, m^3; return the part of it that was missing."""
    found = volume(radii, w)
    factor = (content / found) ** (1.0 / 3.0)
    for i in range(len(radii)):
        radii[i] *= factor
    return 1.0 - found / content


@kernel("UniTuple(float64, 3)(float64[::1], float64[:,::1], float64, float64)")
def centroid(radii: Any, vectors: Any, w: Any, content: Any) -> Any:
    """Return the centroid, m, in the axes of the directions (n, 3)."""
    x, y, z = 0.0, 0.0, 0.0
    for i in range(len(radii)):
        fourth = radii[i] ** 4
        x += fourth * vectors[i, 0]
        y += fourth * vectors[i, 1]
        z += fourth * vectors[i, 2]
    scale = 0.25 * w / content
    return scale * x, scale * y, scale * z


@kernel("void(float64[::1], float64[:,::1], int64[:,::1], float64[:,:,::1], float64, float64, float64)")
def shift(radii: Any, vectors: Any, neighbours: Any, weights: Any, x: Any, y: Any, z: Any) -> None:
    """Measure the radii from a place c, m, a small part of them away: r becomes r + (c grad r) / r - c d, to first order.

    Without the gradient each flat side becomes a hollow, the deeper the nearer the places come that it is measured from. With it
    a radius stays among those beside it, so that nothing grows at an edge.
    """
    before = radii.copy()
    along = np.empty(len(radii))
    for i in range(len(radii)):
        along[i] = x * vectors[i, 0] + y * vectors[i, 1] + z * vectors[i, 2]
    for i in range(len(radii)):
        ru, rv, cu, cv = 0.0, 0.0, 0.0, 0.0
        least, most = before[i], before[i]
        for k in range(neighbours.shape[1]):
            least, most = min(least, before[neighbours[i, k]]), max(most, before[neighbours[i, k]])
            rise, ahead = before[neighbours[i, k]] - before[i], along[neighbours[i, k]] - along[i]
            ru += weights[i, k, 0] * rise
            rv += weights[i, k, 1] * rise
            cu += weights[i, k, 0] * ahead
            cv += weights[i, k, 1] * ahead
        radii[i] = min(max(before[i] + (cu * ru + cv * rv) / before[i], least), most) - along[i]


@kernel("float64(float64[::1], float64[:,::1], int64[:,::1], float64[:,:,::1], float64, float64)")
def centre(radii: Any, vectors: Any, neighbours: Any, weights: Any, w: Any, content: Any) -> Any:
    """Measure the radii from the centroid again, and restore the volume; return the part of it that was missing."""
    x, y, z = centroid(radii, vectors, w, content)
    shift(radii, vectors, neighbours, weights, x, y, z)
    least = SMALLEST * (0.75 * content / math.pi) ** (1.0 / 3.0)
    for i in range(len(radii)):
        radii[i] = max(radii[i], least)
    return rescale(radii, w, content)
