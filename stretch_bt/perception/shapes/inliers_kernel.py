"""The mixture of noise and outliers, compiled; inliers.py says what it is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.perception.arrays_kernel import ranked, solve_in_place

__all__ = ["bulk", "fill_weights", "first_mixture", "next_mixture", "normal_step", "settle_line"]

TUKEY = 4.685  # 95 % efficiency on Gaussian noise
MAD_TO_SD = 1.4826
NEAR = 10.0  # standard deviations within which outliers could be taken for noise
MOST_OUTLIERS = 0.5  # share beyond which outliers could as well be the surface
L1_STEPS, STEPS = 5, 9
_MIXTURE = "UniTuple(float64,3)(float64[::1],"


@kernel("float64(float64[::1],int64)")
def bulk(residuals: Any, freedom: Any) -> Any:
    """Return the standard deviation of the bulk of residuals (n,), as `scale_of` does."""
    size = np.abs(residuals)
    cut = TUKEY * MAD_TO_SD * ranked(size, size.size // 2)
    inside = 0
    for n in range(size.size):
        if size[n] <= cut:
            size[inside] = size[n]
            inside += 1
    return MAD_TO_SD * ranked(size[:inside], inside // 2) * math.sqrt(inside / max(inside - freedom, 1))


@kernel(_MIXTURE + "float64[::1],float64)")
def mixture(residuals: Any, weights: Any, scale: Any) -> Any:
    """Return scale, below and above, where each residual (n,) is noise with the probability `weights` (n,)."""
    size = residuals.size
    inlying, least, most, below, above = 0.0, np.inf, -np.inf, 0.0, 0.0
    for n in range(size):
        r, outlying = residuals[n], 1.0 - weights[n]
        inlying += weights[n]
        least, most = min(least, r), max(most, r)
        if abs(r) < NEAR * scale:
            if r > 0.0:
                above += outlying
            else:
                below += outlying
    share = size * max(inlying / size, 1.0 - MOST_OUTLIERS)
    # An outlier may be anywhere up to the farthest, even if none is near.
    anywhere = 0.5 / max(most - least, 2.0 * NEAR * scale)
    return scale, max(below / (NEAR * scale), anywhere) / share, max(above / (NEAR * scale), anywhere) / share


@kernel(_MIXTURE + "int64,float64)")
def first_mixture(residuals: Any, freedom: Any, floor: Any) -> Any:
    """Return the mixture of residuals (n,) whose bulk is noise."""
    scale = max(bulk(residuals, freedom), floor)
    return mixture(residuals, (np.abs(residuals) <= TUKEY * scale).astype(np.float64), scale)


@kernel(_MIXTURE + "float64[::1],int64,float64)")
def next_mixture(residuals: Any, weights: Any, freedom: Any, floor: Any) -> Any:
    """Return the mixture of residuals (n,) that are noise with the probability `weights` (n,)."""
    squares, total = 0.0, 0.0
    for n in range(residuals.size):
        squares += weights[n] * residuals[n] * residuals[n]
        total += weights[n]
    return mixture(residuals, weights, max(math.sqrt(squares / max(total - freedom, 1.0)), floor))


@kernel("void(float64[::1],float64,float64,float64,float64[::1])")
def fill_weights(residuals: Any, scale: Any, below: Any, above: Any, weights: Any) -> None:
    """Fill the probability (n,) that each residual (n,) is noise."""
    high = math.sqrt(2.0 * math.pi) * scale
    for n in range(residuals.size):
        u = residuals[n] / scale
        density = (above if u > 0.0 else below) * high
        weights[n] = 1.0 / (1.0 + density * math.exp(min(0.5 * u * u, 600.0)))


@kernel("boolean(float64[:,::1],float64[::1],float64[::1],float64[::1])")
def normal_step(jacobian: Any, weights: Any, residuals: Any, step: Any) -> Any:
    """Fill the weighted least-squares step (p,) for residuals (n,) with derivatives (p, n); False where one is left free."""
    p = step.size
    matrix, weighted = np.empty((p, p)), np.empty(residuals.size)
    for i in range(p):
        total = 0.0
        for n in range(weighted.size):
            weighted[n] = weights[n] * jacobian[i, n]
            total += weighted[n] * residuals[n]
        step[i] = total
        for j in range(i + 1):
            total = 0.0
            for n in range(weighted.size):
                total += weighted[n] * jacobian[j, n]
            matrix[i, j] = total
    scale = np.empty(p)
    for i in range(p):
        scale[i] = 1.0 / math.sqrt(max(matrix[i, i], 1e-300))
    for i in range(p):  # equilibrated, so that the smallest pivot means the same for all units
        step[i] *= scale[i]
        for j in range(i + 1):
            matrix[i, j] = matrix[i, j] * scale[i] * scale[j]
    if not solve_in_place(matrix, step):
        return False
    for i in range(p):
        step[i] *= scale[i]
    return True


@kernel("UniTuple(float64,2)(float64[::1])")
def half_of(values: Any) -> Any:
    """Return the middle and the standard deviation of the shortest interval with half of the values, as `densest_half`."""
    ranks = np.sort(values)
    half = values.size // 2
    first = 0
    for n in range(values.size - half):
        if ranks[n + half] - ranks[n] < ranks[first + half] - ranks[first]:
            first = n
    low, high = ranks[first], ranks[first + half]
    return 0.5 * (low + high), 0.5 * MAD_TO_SD * (high - low)


@kernel("boolean(float64[:,::1],float64[::1],float64,float64[::1],float64[::1])")
def settle_line(design: Any, z: Any, floor: Any, solution: Any, weights: Any) -> Any:
    """Fill the solution (p,) of z = solution @ design (p, n) and the weights (n,); False where one is left free."""
    p, count = design.shape
    residuals = np.empty(count)
    weights[:] = 1.0
    for step in range(STEPS):
        if not normal_step(design, weights, z, solution):
            return False
        for n in range(count):
            residuals[n] = z[n]
            for i in range(p):
                residuals[n] -= solution[i] * design[i, n]
        if step < L1_STEPS:
            least = 0.1 * max(bulk(residuals, p), floor)
            for n in range(count):
                weights[n] = 1.0 / max(abs(residuals[n]), least)
            continue
        # Outliers to one side draw the median after them, but not the densest half.
        middle, spread = half_of(residuals) if step == L1_STEPS else (0.0, bulk(residuals, p))
        cut = TUKEY * max(spread, floor)
        for n in range(count):
            u = (residuals[n] - middle) / cut
            t = max(1.0 - u * u, 0.0)
            weights[n] = t * t
    return True
