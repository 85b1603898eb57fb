"""The noise of a surface as a sum of white and smooth parts, from the residuals of its pixels to a fit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.shapes.contact_cells import Cells

__all__ = ["NoiseParts", "Whiten", "noise_left", "whitener"]

Array = npt.NDArray[np.float64]
Whiten = Callable[[Array], Array]  # (n,) or (n, p) -> the same, with independent errors of size 1

LAGS = (1, 2, 3, 4, 5, 6, 8, 10, 13, 17)  # pixels
FARTHEST = 0.25  # largest lag, as a share of the residuals' width
LENGTHS = np.geomspace(0.6, 6.8, 15)  # pixels
CUT = 4.5  # standard deviations beyond which a difference is no noise
LEAST_WHITE = 0.01  # least share of the variance: the shared part is never known better
NEAR, UNSEEN = (
    0.35,
    0.15,
)  # of a cell's side, up to which noise is its own; of the white noise's power, up to which smooth noise is nothing
TAKEN, MOST_TAKEN = (
    10.0,
    0.5,
)  # independent errors that a fit takes into its parameters, and the share of a part that it may
SURE = 3.0  # standard deviations of a variance by so many pixels, below which smooth parts are chance
LEAST_PART = 1e-3


@dataclass(frozen=True, slots=True)
class NoiseParts:
    """Variances, m^2: of white noise, and of smooth parts (variance, length), white noise after a Gaussian of a length, pixels."""

    white: float
    smooth: tuple[tuple[float, float], ...] = ()

    @property
    def variance(self) -> float:
        """Variance of one pixel, m^2."""
        return self.white + sum(v for v, _ in self.smooth)

    @property
    def area(self) -> float:
        """Number of pixels over which noise is alike."""
        smooth = sum(max(_alike(s), 1.0) * v for v, s in self.smooth)
        return (self.white + smooth) / self.variance if self.variance > 0.0 else 1.0

    def seen_by(self, cells: Cells) -> NoiseParts:
        """Return the noise with parts that hardly reach from cell to cell, or are hardly there, as if they were white."""
        near = NEAR * math.sqrt(float(np.median(cells.count)))
        white = self.white + sum(_alike(s) * v for v, s in self.smooth if s <= near)
        far = tuple((v, s) for v, s in self.smooth if s > near)
        if sum(_alike(s) * v for v, s in far) < UNSEEN * white:
            return NoiseParts(white + sum(_alike(s) * v for v, s in far))
        return NoiseParts(white, far)

    def shared(self, cells: Cells) -> Array:
        """Return the covariance (n, n) of the cells, in their unit, by the smooth parts: the half below the diagonal alone."""
        from stretch_bt.perception.shapes.contact_noise_kernel import fill_alike

        total = np.zeros((cells.u.size, cells.u.size))
        for variance, length in self.smooth:
            fill_alike(cells.u, cells.v, cells.count, variance, length, total)
        total *= np.multiply.outer(cells.relative_noise, cells.relative_noise) / cells.size**2
        return total.T

    def own(self, cells: Cells, share: float) -> Array:
        """Return the variance (n,) that each cell has by itself, in its unit, and at least of `share` of a pixel's error."""
        least = share**2 * self.variance if self.smooth else 0.0
        return np.asarray(np.maximum(self.white / cells.count, least) * (cells.relative_noise / cells.size) ** 2)


def _alike(length: float) -> float:
    """Return the number of pixels over which white noise is alike after a Gaussian of a length, pixels."""
    return 4.0 * math.pi * length**2


def whitener(own: Array, shared: Array | None = None) -> Whiten:
    """Return the function that turns errors with variances (n,), and a covariance (n, n) besides, into independent ones of size 1.

    Of the covariance the half below the diagonal is looked at.
    """
    if shared is None:
        each = 1.0 / np.sqrt(own)
        return lambda errors: np.asarray((errors.T * each).T)
    from scipy.linalg import cholesky
    from scipy.linalg.lapack import dtrtrs

    lower = cholesky(shared + np.diag(own), lower=True, overwrite_a=True, check_finite=False)
    # What scipy lays around this call takes longer than the call where errors are one column.
    return lambda errors: np.asarray(dtrtrs(lower, errors, lower=1)[0]).reshape(errors.shape)


def noise_left(residuals: Array, floor: float) -> NoiseParts:
    """Return the noise that residuals (h, w), m, NaN where there are none, show: half the mean squared differences over lags.

    They are fitted by parts that are at least 0. `floor`, m^2, is the least variance.
    """
    from scipy.optimize import nnls

    from stretch_bt.perception.shapes.contact_noise_kernel import half_square

    whole = MAD_TO_SD * quantile(np.abs(residuals[np.isfinite(residuals)]))
    lags = np.array([lag for lag in LAGS if lag <= max(4.0, FARTHEST * min(residuals.shape))], float)
    halves = np.array([half_square(residuals, int(lag), CUT * math.sqrt(2.0) * whole) for lag in lags])
    known = halves > 0.0
    if not known.any():
        return NoiseParts(floor)
    lags, halves = lags[known], halves[known]
    parts = np.concatenate([np.ones((len(lags), 1)), 1.0 - np.exp(-(lags[:, None] ** 2) / (4.0 * LENGTHS**2))], axis=1)
    found, _ = nnls(parts / halves[:, None], np.ones(len(lags)))
    total = max(float(found.sum()), floor)
    pixels = np.count_nonzero(np.isfinite(residuals))
    if float(found[1:].sum()) < SURE * math.sqrt(2.0 / pixels) * total:
        return NoiseParts(total)
    kept = 1.0 - np.minimum(TAKEN * 4.0 * math.pi * LENGTHS**2 / pixels, MOST_TAKEN)
    smooth = tuple(
        (float(v / k), float(s)) for v, k, s in zip(found[1:], kept, LENGTHS, strict=True) if v > LEAST_PART * total
    )
    return NoiseParts(max(float(found[0]), LEAST_WHITE * total, floor), smooth)
