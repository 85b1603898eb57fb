"""Robust location, scale and weights that the estimators share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["TUKEY", "Inliers", "densest_half", "quantile", "sample", "scale_of", "sparse", "tukey_weights"]

Array = npt.NDArray[np.float64]

TUKEY = 4.685  # 95 % efficiency on Gaussian noise
MAD_TO_SD = 1.4826
NEAR = 10.0  # standard deviations within which outliers could be taken for noise
MOST_OUTLIERS = 0.5  # share beyond which outliers could as well be the surface


def quantile(values: FloatArray, share: float = 0.5) -> float:
    """Return the value of (n,) that a share of them does not reach; the median unless told otherwise."""
    at = min(int(share * values.size), values.size - 1)
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


def densest_half(values: Array) -> tuple[float, float]:
    """Return the middle and the standard deviation of the shortest interval that holds half of the values.

    The standard deviation is that of Gaussian values of which half lie there (Rousseeuw and Leroy, Robust Regression and
    Outlier Detection, 1987, section 4.4).
    """
    ranked = np.sort(values)
    half = values.size // 2
    widths = ranked[half:] - ranked[: ranked.size - half]
    first = int(np.argmin(widths))
    return float(ranked[first] + ranked[first + half]) / 2.0, MAD_TO_SD * float(widths[first]) / 2.0


def tukey_weights(u: Array) -> Array:
    """Return Tukey's biweight (1 - u^2)^2 of residuals in units of the cut, 0 beyond it."""
    t = np.maximum(1.0 - u * u, 0.0)
    return t * t


@dataclass(frozen=True, slots=True)
class Inliers:
    """Residuals as a mixture: Gaussian of standard deviation `scale`, and outliers spread evenly on either side of it.

    `below` and `above` are the density of outliers on each side next to the noise, over the share of inliers. Torr and
    Zisserman, MLESAC, Computer Vision and Image Understanding, 2000, section 4, there with one density over all that is
    seen: far outliers then cost inliers, and outliers to one side pull the other way.
    """

    scale: float
    below: float
    above: float

    @classmethod
    def first(cls, residuals: Array, freedom: int, floor: float) -> Self:
        """Return a mixture from the bulk of residuals (n,) of a fit with `freedom` parameters."""
        scale = max(scale_of(residuals, freedom), floor)
        return cls._of(residuals, (np.abs(residuals) > TUKEY * scale).astype(np.float64), scale)

    def next(self, residuals: Array, weights: Array, freedom: int, floor: float) -> Self:
        """Return the mixture after one step of expectation maximisation, given the weights by this one."""
        squares = float(weights @ (residuals * residuals))
        scale = max(float(np.sqrt(squares / max(float(weights.sum()) - freedom, 1.0))), floor)
        return self._of(residuals, 1.0 - weights, scale)

    @classmethod
    def _of(cls, residuals: Array, outlying: Array, scale: float) -> Self:
        """Return the mixture in which each residual is an outlier with the probability `outlying` (n,)."""
        inlying = max(1.0 - float(outlying.mean()), 1.0 - MOST_OUTLIERS)
        near = np.where(np.abs(residuals) < NEAR * scale, outlying, 0.0)
        above = float(near[residuals > 0.0].sum())
        # An outlier may be anywhere up to the farthest, even if none is near.
        anywhere = 0.5 / max(float(np.ptp(residuals)), 2.0 * NEAR * scale)
        densities = (max(count / (NEAR * scale), anywhere) for count in (float(near.sum()) - above, above))
        return cls(scale, *(density / residuals.size / inlying for density in densities))

    def weights(self, residuals: Array) -> Array:
        """Return the probability (n,) that each residual is noise and not an outlier."""
        density = np.where(residuals > 0.0, self.above, self.below) * (np.sqrt(2.0 * np.pi) * self.scale)
        u = residuals / self.scale
        return np.asarray(1.0 / (1.0 + density * np.exp(np.minimum(0.5 * u * u, 600.0))))

    def spread(self, residuals: Array, weights: Array, freedom: int) -> float:
        """Return the variance of one inlier that an M-estimate with these weights has (Huber, 1981, section 7.6)."""
        u = residuals / self.scale
        total = float(weights.sum())
        psi = u * weights
        slope = float((weights - u * psi * (1.0 - weights)).sum())
        return float(psi @ psi) * total / max(slope, 0.1 * total) ** 2 * total / (total - freedom) * self.scale**2


def sparse(values: FloatArray, most: int = 20000) -> FloatArray:
    """Return at most about `most` of the values, evenly spaced: enough for a quantile."""
    return values[:: max(1, values.size // most)]


def sample(values: FloatArray, valid: MaskArray, most: int = 2000) -> FloatArray:
    """Return the valid values on a grid of about `most` pixels of an image, or all where the grid meets none."""
    step = max(1, round((valid.size / most) ** 0.5))
    some = values[::step, ::step][valid[::step, ::step]]
    return some if some.size else values[valid]
