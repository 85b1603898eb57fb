"""Residuals as a mixture of noise and outliers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.shapes.inliers_kernel import fill_weights, first_mixture, next_mixture

__all__ = ["Inliers"]

Array = npt.NDArray[np.float64]


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
        return cls(*first_mixture(residuals, freedom, floor))

    def next(self, residuals: Array, weights: Array, freedom: int, floor: float) -> Self:
        """Return the mixture after one step of expectation maximisation, given the weights by this one."""
        return type(self)(*next_mixture(residuals, weights, freedom, floor))

    def weights(self, residuals: Array) -> Array:
        """Return the probability (n,) that each residual is noise and not an outlier."""
        weights = np.empty_like(residuals)
        fill_weights(residuals, self.scale, self.below, self.above, weights)
        return weights

    def spread(self, residuals: Array, weights: Array, freedom: int) -> float:
        """Return the variance of one inlier that an M-estimate with these weights has (Huber, 1981, section 7.6)."""
        u = residuals / self.scale
        total = float(weights.sum())
        psi = u * weights
        slope = float((weights - u * psi * (1.0 - weights)).sum())
        return float(psi @ psi) * total / max(slope, 0.1 * total) ** 2 * total / (total - freedom) * self.scale**2
