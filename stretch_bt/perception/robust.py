"""Robust location, scale and weights that the estimators share."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["TUKEY", "quantile", "sample", "scale_of", "sparse", "tukey_weights"]

Array = npt.NDArray[np.float64]

TUKEY = 4.685  # 95 % efficiency on Gaussian noise
MAD_TO_SD = 1.4826
_COMPILED = (np.dtype(np.float64), np.dtype(np.float32))


def quantile(values: FloatArray, share: float = 0.5) -> float:
    """Return the value of (n,) that a share of them does not reach; the median by default."""
    from stretch_bt.perception.arrays_kernel import order_statistic

    at = min(int(share * values.size), values.size - 1)
    if values.size and values.dtype in _COMPILED and values.flags.writeable:
        found: float = order_statistic(values, at)
        if found == found:
            return found
    ranked = values.copy()
    ranked.partition(at)
    return float(ranked[at])


def scale_of(residuals: Array, freedom: int = 0) -> float:
    """Return the standard deviation of the bulk of zero-centred residuals, from their median absolute value.

    Residuals beyond the Tukey cut are dropped and the median taken again, so that outliers do not inflate it.
    `freedom` is the number of parameters that were fitted to the residuals.
    """
    size = np.abs(residuals)
    first = MAD_TO_SD * quantile(size)
    inside = size[size <= TUKEY * first]
    sd = MAD_TO_SD * quantile(inside)
    return sd * float(np.sqrt(inside.size / max(inside.size - freedom, 1)))


def tukey_weights(u: Array) -> Array:
    """Return Tukey's biweight (1 - u^2)^2 of residuals in units of the cut, 0 beyond it."""
    t = np.maximum(1.0 - u * u, 0.0)
    return t * t


def sparse(values: FloatArray, most: int = 20000) -> FloatArray:
    """Return at most about `most` of the values, evenly spaced: enough for a quantile."""
    return values[:: max(1, values.size // most)]


def sample(values: FloatArray, valid: MaskArray, most: int = 2000) -> FloatArray:
    """Return the valid values on a grid of about `most` pixels of an image, or all where the grid meets none."""
    step = max(1, round((valid.size / most) ** 0.5))
    some = values[::step, ::step][valid[::step, ::step]]
    return some if some.size else values[valid]
