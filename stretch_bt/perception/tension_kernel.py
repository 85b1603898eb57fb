"""Robust total least squares of a line through 0, compiled; tension.py says what for."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.perception.arrays_kernel import ranked

__all__ = ["settle_angle"]


@kernel()
def scale_of(size: Any, factor: Any, cut: Any) -> Any:
    """Return what `robust.scale_of` does, of absolute residuals (n,), which change their order, and one parameter."""
    first, inside = factor * ranked(size, size.size // 2), 0
    for n in range(size.size):
        if size[n] <= cut * first:
            size[n], size[inside] = size[inside], size[n]
            inside += 1
    if inside == 0:
        return math.nan
    return factor * ranked(size[:inside], inside // 2) * math.sqrt(inside / max(inside - 1, 1))


@kernel("UniTuple(float64,2)(float64[::1],float64[::1],float64[::1],float64,float64,float64,int64)")
def settle_angle(x: Any, y: Any, weights: Any, factor: Any, cut: Any, close: Any, rounds: Any) -> Any:
    """Return the angle of the direction in which pairs (n,) scatter least, and their standard deviation along it.

    The first angle comes from the weights (n,) as they are; then they become Tukey's, at `cut` standard deviations. It
    ends when the angle moves by no more than `close`.
    """
    angle, sd, size = math.inf, 0.0, np.empty(x.size)
    for _ in range(rounds):
        xx, xy, yy = 0.0, 0.0, 0.0
        for n in range(x.size):
            xx += weights[n] * x[n] * x[n]
            xy += weights[n] * x[n] * y[n]
            yy += weights[n] * y[n] * y[n]
        before, angle = angle, 0.5 * math.atan2(2.0 * xy, xx - yy) + 0.5 * math.pi
        c, s = math.cos(angle), math.sin(angle)
        for n in range(x.size):
            size[n] = abs(c * x[n] + s * y[n])
        sd = max(scale_of(size, factor, cut), 1e-12)
        if abs(angle - before) < close:
            break
        for n in range(x.size):
            u = (c * x[n] + s * y[n]) / (cut * sd)
            t = max(1.0 - u * u, 0.0)
            weights[n] = t * t
    return angle, sd
