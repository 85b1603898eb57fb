"""Where the noise of a surface is larger than elsewhere, from the residuals of its pixels to a fit."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import MAD_TO_SD, quantile

__all__ = ["SIDE", "relative_noise"]

Array = npt.NDArray[np.float64]

LAG, CUT = 2, 4.5  # pixels; standard deviations beyond which a difference is no noise
SIDE = 8  # pixels, of the squares that noise is measured in, each with its eight neighbours
LEAST_SHARE, MOST = 0.2, 4.0  # least share of the spread that is no chance; largest factor
AREAS = 1.5  # how much more differences of noise alike over an area scatter than those of so many independent pixels


def relative_noise(residuals: Array, area: float) -> Array | None:
    """Return the standard deviation of noise in squares (rows, columns) of SIDE pixels over its mean, None where it is even.

    It is measured by differences of pixels near each other, which a fit that does not hold hardly changes, and drawn to 1 as far as it may be
    chance. `residuals` (h, w), m, are NaN where there are none; `area`, pixels, is over how many of them noise is alike.
    """
    power, count = (_around(sums) for sums in _differences(residuals))
    known = (count > SIDE**2) & (power > 0.0)  # pixels of one count show no noise
    if np.count_nonzero(known) < 9:
        return None
    ratio = np.log(power[known] / count[known])
    chance = float(np.mean(AREAS * max(area, 1.0) / count[known]))
    spread = float(np.var(ratio))
    share = 1.0 - chance / spread if spread > 0.0 else 0.0
    if share < LEAST_SHARE:
        return None
    found = np.zeros(power.shape)
    found[known] = 0.5 * share * (ratio - math.log(power[known].sum() / count[known].sum()))
    return np.exp(np.clip(found, -math.log(MOST), math.log(MOST)))


def _differences(residuals: Array) -> tuple[Array, Array]:
    """Return the sums of squared differences in squares, and how many they are."""
    rows, columns = (max(n // SIDE, 1) for n in residuals.shape)
    power, count = np.zeros((rows, columns)), np.zeros((rows, columns))
    for axis in (0, 1):
        apart = np.moveaxis(residuals, axis, 0)
        apart = np.moveaxis(apart[LAG:] - apart[:-LAG], 0, axis)
        seen = np.isfinite(apart)
        if seen.any():
            seen &= np.abs(apart) < CUT * MAD_TO_SD * quantile(np.abs(apart[seen]))
            power += _sums(np.where(seen, apart, 0.0) ** 2, rows, columns)
            count += _sums(seen.astype(float), rows, columns)
    return power, count


def _sums(values: Array, rows: int, columns: int) -> Array:
    at = [np.minimum(np.arange(0, n * SIDE, SIDE), m - 1) for n, m in zip((rows, columns), values.shape, strict=True)]
    return np.add.reduceat(np.add.reduceat(values, at[0], axis=0), at[1], axis=1)


def _around(values: Array) -> Array:
    """Return sums over each square and its neighbours."""
    import cv2

    return np.asarray(cv2.boxFilter(values, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT))
