"""The polynomials of a skirt's prior and their derivatives, compiled; prior.py says what they are."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["fill_mean"]

_ROWS = "float64[::1]," * 5


@kernel(f"void({_ROWS}int64[:,:],float64[:,:],float64[::1],float64[:,::1])")
def fill_mean(
    at: Any,
    low: Any,
    high: Any,
    center: Any,
    scale: Any,
    exponents: Any,
    coefficients: Any,
    mean: Any,
    slopes: Any,
) -> None:
    """Fill the targets (targets,) at features (n,), and their derivatives (targets, n), 0 beyond the range that was seen."""
    terms, count = exponents.shape
    degree = 0
    for term in range(terms):
        for f in range(count):
            degree = max(degree, exponents[term, f])
    powers, steep = np.ones((count, degree + 1)), np.zeros((count, degree + 1))
    for f in range(count):
        clipped = min(max(at[f], low[f]), high[f])
        u = (clipped - center[f]) / scale[f]
        by = 1.0 / scale[f] if clipped == at[f] else 0.0
        for d in range(1, degree + 1):
            powers[f, d] = powers[f, d - 1] * u
            steep[f, d] = d * powers[f, d - 1] * by
    mean[:] = 0.0
    slopes[:] = 0.0
    for term in range(terms):
        for moved in range(-1, count):
            product = 1.0
            for f in range(count):
                product *= steep[f, exponents[term, f]] if f == moved else powers[f, exponents[term, f]]
            if moved < 0:
                for target in range(mean.size):
                    mean[target] += product * coefficients[term, target]
            else:
                for target in range(mean.size):
                    slopes[target, moved] += product * coefficients[term, target]
