"""Sums of pixels in cells, and least squares that are not negative, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["descend", "fill_cells"]


@kernel("void(float64[:,:],int64[:],int64[:],int64,float64[:,:,::1])")
def fill_cells(design: Any, rows: Any, columns: Any, step: Any, summed: Any) -> None:
    """Add weights (k, n) of pixels at rows and columns (n,) to sums (k, h, w) over cells of `step` by `step` pixels."""
    cells, wide, flat = np.empty(rows.size, dtype=np.int64), summed.shape[2], summed.reshape(summed.shape[0], -1)
    top, left = rows.min(), columns.min()
    for n in range(rows.size):
        v, u = rows[n] - top, columns[n] - left
        cells[n] = v * wide + u if step == 1 else v // step * wide + u // step
    for k in range(design.shape[0]):
        weights, total = design[k], flat[k]
        for n in range(cells.size):
            total[cells[n]] += weights[n]


@kernel("void(float64[:,::1],float64[::1],boolean[::1],int64,float64,float64[::1])")
def descend(normal: Any, right: Any, free: Any, sweeps: Any, settled: Any, q: Any) -> None:
    """Move q (k,) to the least of q . normal . q / 2 - right . q that is not negative, one number after the other, where they are free."""
    for _ in range(sweeps):
        moved = 0.0
        for k in range(q.size):
            if free[k]:
                along = 0.0
                for m in range(q.size):
                    along += normal[k, m] * q[m]
                value = max(q[k] + right[k] - along, 0.0)
                moved, q[k] = max(moved, abs(value - q[k])), value
        if moved < settled:
            break
