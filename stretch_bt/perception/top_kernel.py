"""Reweighted least squares at a fixed scale, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.perception.arrays_kernel import solve_in_place

__all__ = ["m_sd", "settle"]


@kernel("boolean(float64[:,::1],float64[::1],float64[::1],float64,float64,int64)")
def settle(design: Any, z: Any, q: Any, cut: Any, close: Any, rounds: Any) -> Any:
    """Move q (k,) to the fit of z (n,) by design (k, n) with Tukey's weights at a cut; False where there is none.

    It ends when no parameter moves by more than `close`.
    """
    k, n = design.shape
    weights, weighted = np.empty(n), np.empty(n)
    normal, right = np.empty((k, k)), np.empty(k)
    for _ in range(rounds):
        weights[:] = z
        for i in range(k):
            for p in range(n):
                weights[p] -= q[i] * design[i, p]
        for p in range(n):
            t = max(1.0 - (weights[p] / cut) ** 2, 0.0)
            weights[p] = t * t
        for i in range(k):
            total = 0.0
            for p in range(n):
                weighted[p] = weights[p] * design[i, p]
                total += weighted[p] * z[p]
            right[i] = total
            for j in range(i + 1):
                total = 0.0
                for p in range(n):
                    total += weighted[p] * design[j, p]
                normal[i, j] = total
        if not solve_in_place(normal, right):
            return False
        moved = 0.0
        for i in range(k):
            moved = max(moved, abs(right[i] - q[i]))
            q[i] = right[i]
        if moved < close:
            break
    return True


@kernel("float64(float64[::1],float64,int64)")
def m_sd(residuals: Any, cut: Any, parameters: Any) -> Any:
    """Return the standard deviation of one of residuals (n,) to an estimate with Tukey's weights (Huber, 1981, section 7.6)."""
    squares, slopes, inside = 0.0, 0.0, 0
    for n in range(residuals.size):
        u = residuals[n] / cut
        t = max(1.0 - u * u, 0.0)
        squares += u * u * t * t * t * t
        slopes += t * (1.0 - 5.0 * u * u)
        inside += t > 0.0
    count = max(inside, parameters + 1)
    return cut * math.sqrt(squares / (count - parameters) * residuals.size / count) / max(slopes / max(inside, 1), 0.1)
