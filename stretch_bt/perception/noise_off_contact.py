"""Noise of long correlation, measured where the membrane is free: there its mean over an ellipse is its height in the middle.

The free membrane obeys T_i z_xx + T_j z_yy = 0 (the shallow membrane). With y scaled by sqrt(T_i / T_j) it is harmonic, and the mean of a
harmonic function over a disc is its value in the middle of the disc. So what an ellipse of that shape leaves of the middle is noise, however
steep the membrane is, and noise of a length up to the ellipse's own passes nearly whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.surface import Cleaned
from stretch_bt.perception.types import MaskArray

__all__ = ["Ellipses", "expected", "left_by_ellipses"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]

STEP = 4  # pixels of a bin, by side; a power of 2
RADIUS = 16.0  # pixels, the geometric mean of the semi-axes: the noise that passes is up to half as long
LAGS = (0, 1, 2, 4)  # bins
RATIOS: tuple[float, ...] = tuple(np.geomspace(1.0, 5.0, 9).tolist())  # of the semi-axes along j and i
SEEN = 0.8  # share of a bin's pixels that must be valid
WHOLE = 0.95  # share of the ellipse that must be
MISFIT = 0.0025
LEAST = 60  # bins from which a residual tells anything
CUT = 3.0  # standard deviations past which a residual is no noise

Ellipses = dict[float, Array]


def left_by_ellipses(cleaned: Cleaned, free: MaskArray) -> Ellipses:
    """Return the covariances (LAGS,), m^2, of what ellipses of several RATIOS leave of a frame; none where too little is free.

    Parameters
    ----------
    free : (h, w) bool, of the cleaned part
        Where the membrane touches nothing.
    """
    raw, share = cleaned.bins(STEP)
    rows, columns = raw.shape
    beside = np.zeros(raw.shape, dtype=np.float32)
    cut = free[::STEP, ::STEP][:rows, :columns]
    beside[: cut.shape[0], : cut.shape[1]] = cut
    found = {ratio: _left(raw, share, beside, ratio) for ratio in RATIOS}
    return {ratio: seen for ratio, seen in found.items() if seen is not None and seen[0] > 0.0}


def _left(raw: Image, share: Image, free: Image, ratio: float) -> Array | None:
    import cv2

    kernel = _ellipse(ratio)

    def mean(image: Image) -> Any:
        return cv2.filter2D(image, cv2.CV_32F, kernel, borderType=cv2.BORDER_CONSTANT)

    cover = mean(share)
    whole = (cover > WHOLE) & (mean(free) > 0.999) & (share > SEEN)
    if np.count_nonzero(whole) < LEAST:
        return None
    rest = np.where(whole, raw - mean(raw * share) / np.maximum(cover, np.float32(1e-3)), np.float32(0))
    whole &= np.abs(rest) < CUT * MAD_TO_SD * quantile(np.abs(rest[whole]))
    if np.count_nonzero(whole) < LEAST:
        return None
    rest[~whole] = 0.0
    return np.array([_covariance(rest, whole, lag) for lag in LAGS])


def _covariance(rest: Image, seen: MaskArray, lag: int) -> float:
    """Return the covariance of a residual with itself `lag` bins aside and below."""
    n = len(rest) - lag, rest.shape[1] - lag
    pairs = int(np.count_nonzero(seen[lag:] & seen[: n[0]]) + np.count_nonzero(seen[:, lag:] & seen[:, : n[1]]))
    total = float(np.vdot(rest[lag:], rest[: n[0]])) + float(np.vdot(rest[:, lag:], rest[:, : n[1]]))
    return total / float(max(pairs, 1))


@lru_cache(maxsize=len(RATIOS))
def _ellipse(ratio: float) -> Image:
    """Return the mean over an ellipse as a kernel of bins, of odd shape."""
    half_i, half_j = (RADIUS / STEP * factor for factor in (1.0 / math.sqrt(ratio), math.sqrt(ratio)))
    v, u = (np.arange(-math.ceil(half), math.ceil(half) + 1) for half in (half_j, half_i))
    past = (1.0 - np.hypot(u[None, :] / half_i, v[:, None] / half_j)) * min(half_i, half_j)
    inside = np.clip(past + 0.5, 0.0, 1.0)
    return np.asarray(inside / inside.sum(), dtype=np.float32)


@lru_cache(maxsize=len(RATIOS))
def expected(ratio: float, lengths: tuple[float, ...]) -> Array:
    """Return the covariances (LAGS, k) that an ellipse leaves of noise of variance 1 of each length, pixels."""
    from scipy.signal import correlate2d

    left = -_ellipse(ratio).astype(np.float64)
    left[left.shape[0] // 2, left.shape[1] // 2] += 1.0
    own = correlate2d(left, left)
    v, u = np.indices(own.shape) - (np.array(own.shape) // 2)[:, None, None]
    columns = []
    for length in lengths:
        alike = _alike(length)
        columns.append(
            [0.5 * float((own * (alike(np.hypot(v + lag, u)) + alike(np.hypot(v, u + lag)))).sum()) for lag in LAGS]
        )
    return np.array(columns).T


def _alike(length: float) -> Callable[[Array], Array]:
    """Return the covariance of bins so many bins apart, of noise of variance 1 of a length, pixels."""
    if length == 0.0:
        return lambda away: (away == 0.0) / STEP**2
    square = length**2 / STEP**2
    wider = square + (1.0 - 1.0 / STEP**2) / 12.0  # the bins blur as a Gaussian of their own variance does
    return lambda away: square / wider * np.exp(-(away**2) / (4.0 * wider))
