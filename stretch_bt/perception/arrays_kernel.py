"""Order statistics and small linear systems, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["order_statistic", "ranked", "solve_in_place"]

CELLS = 512  # of a histogram
FEW = 24  # values that are ranked outright
PASSES = 6  # histograms, each within a cell of the last; far outliers take two or three


@kernel("float64(float64[::1],int64)")
def ranked(values: Any, rank: Any) -> Any:
    """Return the value of a rank, and put the smaller ones before it (Hoare, Find, Communications of the ACM, 1961)."""
    low, high = 0, values.size - 1
    while low < high:
        pivot = values[rank]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if j < rank:
            low = i
        if rank < i:
            high = j
    return values[rank]


@kernel("UniTuple(float64,2)(float64[::1])")
def limits(values: Any) -> Any:
    """Return the least and the greatest of values (n,), and infinities where one of them is not a number."""
    low, high, known = values[0], values[0], True
    for n in range(values.size):
        value = values[n]
        known &= value == value
        low = value if value < low else low
        high = value if value > high else high
    return (low, high) if known else (-np.inf, np.inf)


@kernel(["float64(float64[:],int64)", "float64(float32[:],int64)"])
def order_statistic(values: Any, rank: Any) -> Any:
    """Return the value of a rank among values (n,), which stay as they are; not a number where one of them is not finite.

    Histograms narrow the values down to one cell: two passes without branches that depend on the data, where a partition
    mispredicts at every second value.
    """
    kept = np.empty(values.size, dtype=np.float64)
    for n in range(values.size):
        kept[n] = values[n]
    low, high = limits(kept)
    if not high - low < np.inf:
        return math.nan
    counts = np.empty(CELLS + 1, dtype=np.int64)
    for _ in range(PASSES):
        if kept.size <= FEW or low == high or not CELLS / (high - low) < np.inf:
            break
        scale, cell = CELLS / (high - low), 0
        counts[:] = 0
        for n in range(kept.size):
            counts[int((kept[n] - low) * scale)] += 1
        while counts[cell] <= rank:
            rank -= counts[cell]
            cell += 1
        within, size = np.empty(counts[cell] + 1), 0
        for n in range(kept.size):
            within[size] = kept[n]
            size += int((kept[n] - low) * scale) == cell
        kept = within[:size]
        low, high = limits(kept)
    return low if low == high else ranked(kept, rank)


@kernel()
def solve_in_place(normal: Any, right: Any) -> Any:
    """Turn the right side (k,) into the solution, by Cholesky's decomposition; False where there is none."""
    k = right.size
    for i in range(k):
        for j in range(i + 1):
            total = normal[i, j]
            for m in range(j):
                total -= normal[i, m] * normal[j, m]
            if i > j:
                normal[i, j] = total / normal[j, j]
            elif total > 1e-12 * normal[i, i]:
                normal[i, i] = math.sqrt(total)
            else:
                return False
        for m in range(i):
            right[i] -= normal[i, m] * right[m]
        right[i] /= normal[i, i]
    for i in range(k - 1, -1, -1):
        for m in range(i + 1, k):
            right[i] -= normal[m, i] * right[m]
        right[i] /= normal[i, i]
    return True
