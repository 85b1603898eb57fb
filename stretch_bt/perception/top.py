"""A curved top: the quadratic through it and its vertex."""

from __future__ import annotations

import math
from copy import copy

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.robust import TUKEY, quantile, scale_of
from stretch_bt.units import Estimate

__all__ = ["Places", "Top", "settled"]

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

ENOUGH_PAIRS = 30
SCALES = 2  # times that the noise is estimated anew
ROUNDS = 8  # of weights at one scale
CLEARLY = 3.0  # standard deviations at which a top counts as curved
ROUND = 0.02  # of its curvature, by which that of a round top differs from one direction to another
APART = 14.2  # chi2 of three values with three degrees of freedom beyond which 0.27 % lie, as beyond three standard deviations of one
EVEN: Array = np.array(
    [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 1]], dtype=float
)


def settled(design: Array, z: Array, places: Places) -> tuple[Array, float]:
    """Return the parameters (k,) of a robust fit of z (n,) by design (k, n), and the standard deviation of one residual.

    The deviation holds what Tukey's weights cost and what neighbours share, so that it goes with the covariance of plain
    least squares.
    """
    from stretch_bt.perception.top_kernel import m_sd, settle

    free = len(design)
    q, cut, close = np.zeros(free), np.inf, np.inf
    for turn in range(SCALES + 1):
        if not settle(design, z, q, cut, close, ROUNDS):
            raise IllConditioned(
                "the points in contact lie on one line, which shows no top across it; press deeper, so that an area touches"
            )
        residuals = z - q @ design
        if turn < SCALES:
            scale = max(scale_of(residuals, free), 1e-12)
            cut, close = TUKEY * scale, 0.01 * scale / math.sqrt(len(z))
    return q, m_sd(residuals, cut, free) * _shared(residuals, places)


def _shared(residuals: Array, places: Places) -> float:
    """Return how much wider a mean spreads because neighbouring pixels share their noise; 1 where they do not.

    `places` are the pixels' numbers, row by row, so that neighbours in a row differ by 1.
    """
    neighbours = np.flatnonzero(places[1:] - places[:-1] == 1)
    if neighbours.size < ENOUGH_PAIRS:
        return 1.0
    steps = (residuals[1:] - residuals[:-1])[neighbours]
    together = 1.0 - (quantile(np.abs(steps)) / max(quantile(np.abs(residuals)), 1e-12)) ** 2 / 2.0
    if together < 3.0 / neighbours.size**0.5:
        return 1.0
    # Noise after a Gaussian of l pixels: neighbours correlate as exp(-1 / 4 l^2), and 4 pi l^2 pixels share one value.
    return max(float(np.sqrt(-np.pi / np.log(min(together, 0.99)))), 1.0)


class Top:
    """z = c + b . (x, y) - (kx x^2 + 2 kxy x y + ky y^2) / 2 about `middle`, fitted with Tukey's weights."""

    def __init__(self, cloud: Array, places: Places, middle: Array, *, even: bool) -> None:
        """Fit to points (3, n), m; `even` keeps the curvature the same in all directions."""
        self.middle = middle
        x, y = cloud[0] - middle[0], cloud[1] - middle[1]
        offset = quantile(cloud[2])
        self.size = max(float(np.sqrt((x @ x + y @ y) / len(x))), 1e-12)
        x, y = x / self.size, y / self.size
        bent = [-0.5 * (x * x + y * y)] if even else [-0.5 * x * x, -x * y, -0.5 * y * y]
        design = np.stack([np.ones_like(x), x, y, *bent])
        self.q, sd = settled(design, cloud[2] - offset, places)
        self.sd = sd  # of one point, m
        self.covariance: Array = np.asarray(np.linalg.inv(design @ design.T) * sd * sd, dtype=np.float64)
        self.q[0] += offset
        if even:
            self.q, self.covariance = EVEN @ self.q, EVEN @ self.covariance @ EVEN.T

    def bent(self, known: Estimate | None) -> Top:
        """Return it with the curvature, 1/m, that something else knows, the same in all directions; or as it is where it is clearly not so."""
        if known is None:
            return self
        area = self.size**2
        level, spread, uneven = known.value * area, (known.sd * area) ** 2, (ROUND * known.value * area) ** 2
        off = np.array([level, 0.0, level]) - self.q[3:]
        told = np.array([[spread + uneven, 0.0, spread], [0.0, uneven, 0.0], [spread, 0.0, spread + uneven]])
        apart = np.linalg.inv(self.covariance[3:, 3:] + told)
        if off @ apart @ off > APART:
            return self
        gain = self.covariance[:, 3:] @ apart
        made = copy(self)
        made.q, made.covariance = self.q + gain @ off, self.covariance - gain @ self.covariance[3:]
        return made

    @property
    def curvature(self) -> float:
        """Mean curvature, 1/m."""
        return float(self.q[3] + self.q[5]) / 2.0 / self.size**2

    @property
    def significance(self) -> float:
        """Convexity, in standard deviations, in the direction in which it is least: a vertex along it lies anywhere."""
        kx, kxy, ky = self.q[3:].tolist()
        least = 0.5 * (kx + ky) - math.hypot(0.5 * (kx - ky), kxy)
        angle = 0.5 * math.atan2(-2.0 * kxy, ky - kx)
        x, y = math.cos(angle), math.sin(angle)
        row = np.array([0.0, 0.0, 0.0, x * x, 2.0 * x * y, y * y])
        return float(least) / max(math.sqrt(float(row @ self.covariance @ row)), 1e-300)

    @property
    def is_curved(self) -> bool:
        """Whether it is clearly convex in every direction."""
        return self.significance > CLEARLY

    def _offset(self, most: float) -> Array:
        """Return the vertex from the middle in units of `size`, at most `most` metres away."""
        kx, kxy, ky = self.q[3:]
        step: Array = np.linalg.solve([[kx, kxy], [kxy, ky]], self.q[1:3])
        return step * min(1.0, most / self.size / max(float(np.linalg.norm(step)), 1e-300))

    def vertex(self, most: float) -> Array:
        """Return (x, y) of the vertex, m."""
        return self.middle + self.size * self._offset(most)

    def estimate(self, most: float) -> Estimate:
        """Return the height of the vertex; where it lies does not matter to first order."""
        x, y = self._offset(most)
        row = np.array([1.0, x, y, -0.5 * x * x, -x * y, -0.5 * y * y])
        return Estimate(float(row @ self.q), float(np.sqrt(row @ self.covariance @ row)))
