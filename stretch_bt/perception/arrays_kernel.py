"""Order statistics and small linear systems, compiled."""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["ranked", "solve_in_place"]


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
