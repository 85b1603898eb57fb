"""Sums over pairs of cells and pixels that the noise of a contact asks for, compiled."""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["fill_alike", "half_square"]


@kernel("void(float64[::1],float64[::1],float64[::1],float64,float64,float64[:,::1])")
def fill_alike(u: Any, v: Any, count: Any, variance: Any, length: Any, total: Any) -> None:
    """Add to a covariance (n, n) that of cells at places (n,), of so many pixels each, by smooth noise of a variance and a length.

    The half above the diagonal is filled. A mean over a square blurs as a Gaussian of its variance.
    """
    for i in range(u.size):
        row = total[i]
        for j in range(i, u.size):
            du, dv = u[i] - u[j], v[i] - v[j]
            spread = length * length + (count[i] + count[j]) / 24.0
            row[j] += variance * (length * length) / spread * math.exp(-0.25 * (du * du + dv * dv) / spread)


@kernel("float64(float64[:,::1],int64,float64)")
def half_square(residuals: Any, lag: Any, cut: Any) -> Any:
    """Return half the mean square of differences over a lag, along both axes, without those beyond the cut and not a number."""
    h, w = residuals.shape
    total, count = 0.0, 0
    for i in range(h):
        here = residuals[i]
        for j in range(w - lag):
            apart = here[j + lag] - here[j]
            if abs(apart) <= cut:
                total += apart * apart
                count += 1
        if i + lag < h:
            below = residuals[i + lag]
            for j in range(w):
                apart = below[j] - here[j]
                if abs(apart) <= cut:
                    total += apart * apart
                    count += 1
    return 0.5 * total / count if count else 0.0
