"""Noise that neighbours share: its size and its length, from the residual of an image to Gaussian means."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.smooth import gain
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["area_of", "left_of_one", "noise_of", "spread_of_mean"]

Array = npt.NDArray[np.float64]

LENGTHS: Array = np.concatenate([[0.0], np.geomspace(0.25, 4.0, 30)])
MOST = 6000  # pixels that are looked at
PASSES = (1.0, -4.0, 6.0, -4.0, 1.0)  # of (1 - g)^4, the power that two passes of 1 less a Gaussian g leave


def noise_of(residual: FloatArray, valid: MaskArray, sigma: float) -> tuple[float, float]:
    """Return the standard deviation of an image's noise and the length, pixels, over which neighbours share it.

    Parameters
    ----------
    residual : (h, w) float
        The image with its Gaussian mean over `sigma` pixels subtracted, twice: that takes a surface
        away up to its third derivatives.
    valid : (h, w) bool

    Returns
    -------
    sd : float
        In the unit of the image; the share that the means took away is added again.
    length : float
        Pixels of the Gaussian that makes white noise alike to such a length; 0 where the noise is white.
    """
    every = max(1, math.ceil(residual.size / MOST))
    rows, seen = residual[::every], valid[::every]
    both = seen[:, 1:] & seen[:, :-1]
    if not both.any():
        return 0.0, 0.0
    sd = MAD_TO_SD * quantile(np.abs(rows[seen]))
    steps = MAD_TO_SD * quantile(np.abs((rows[:, 1:] - rows[:, :-1])[both]))
    if sd == 0.0:
        return 0.0, 0.0
    left, apart = _left_over(sigma)
    length = float(np.interp(-(steps**2) / (2.0 * sd**2), -apart, LENGTHS))
    return sd / math.sqrt(float(np.interp(length, LENGTHS, left))), length


@lru_cache(maxsize=64)
def _left_over(sigma: float) -> tuple[Array, Array]:
    """Return for each length the variance left of 1, and 1 less the correlation of neighbours in the residual."""
    own = np.array([_left(length, sigma, 0.0) for length in LENGTHS])
    apart = 1.0 - np.array([_left(length, sigma, 1.0) for length in LENGTHS]) / own
    return own, np.minimum.accumulate(apart) - 1e-9 * np.arange(len(apart))


def _left(length: float, sigma: float, d: float) -> float:
    """Return the covariance at a distance `d` of the residual of noise of variance 1."""
    if length == 0.0:
        means = (c * math.exp(-(d**2) / (2 * m * sigma**2)) / (2 * math.pi * m * sigma**2) for m, c in _means())
        return float(d == 0.0) + sum(means)
    a = 2.0 * length**2  # white noise after a Gaussian of length l has the correlation exp(-d^2 / 4 l^2)
    spreads = ((c, a + m * sigma**2) for m, c in enumerate(PASSES))
    return sum(c * a / s * math.exp(-(d**2) / (2.0 * s)) for c, s in spreads)


def _means() -> list[tuple[int, float]]:
    return list(enumerate(PASSES))[1:]


def left_of_one(sigma: float, step: int) -> float:
    """Return the variance, of 1, that a pixel of white noise keeps less the means of bins of `step` pixels around it."""
    g = [0.0] + [1.0 / (2.0 * math.pi * m * sigma**2) for m in range(1, 5)]
    return 1.0 + (-2.0 * (2.0 * g[1] - g[2]) + 4.0 * g[2] - 4.0 * g[3] + g[4]) / step**2


def area_of(length: float) -> float:
    """Return how many pixels share one error, at least 1, where noise is shared over a length, pixels.

    It is the sum over the plane of the correlation exp(-d^2 / 4 l^2) of white noise after a Gaussian of l.
    """
    return max(4.0 * math.pi * length**2, 1.0)


def spread_of_mean(length: float, sigma: float, *orders: tuple[int, int, float]) -> float:
    """Return the standard deviation of a filter of `sigma` pixels on noise of sd 1 that is shared over a length."""
    if length < 0.25:
        return gain(sigma, *orders)
    # Both Gaussians are one; white noise that comes out with sd 1 went in with 2 sqrt(pi) times the length.
    joint = round(20.0 * math.hypot(sigma, length)) / 20.0
    return max(2.0 * math.sqrt(math.pi) * length, 1.0) * gain(joint, *orders)
