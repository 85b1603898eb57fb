"""Reweighted least squares at a fixed scale, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.perception.arrays_kernel import solve_in_place

__all__ = ["m_sd", "settle"]


@kernel("UniTuple(float64,4)(float64[::1],float64[:,::1],float64[::1],int64,int64)")
def products(weighted: Any, design: Any, z: Any, first: Any, last: Any) -> Any:
    """Return the sums of products (n,) with four rows of a design (k, n) from `first` on, of which z (n,) stands after `last`.

    A sum waits for the one before it; four at once take no longer. What is past z means nothing.
    """
    a = design[first] if first <= last else z
    b = design[first + 1] if first + 1 <= last else z
    c = design[first + 2] if first + 2 <= last else z
    d = design[first + 3] if first + 3 <= last else z
    total_a, total_b, total_c, total_d = 0.0, 0.0, 0.0, 0.0
    for p in range(weighted.size):
        w = weighted[p]
        total_a += w * a[p]
        total_b += w * b[p]
        total_c += w * c[p]
        total_d += w * d[p]
    return total_a, total_b, total_c, total_d


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
            for p in range(n):
                weighted[p] = weights[p] * design[i, p]
            for j in range(0, i + 2, 4):
                sums = products(weighted, design, z, j, i)
                for m in range(j, min(j + 4, i + 2)):
                    if m <= i:
                        normal[i, m] = sums[m - j]
                    else:
                        right[i] = sums[m - j]
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
