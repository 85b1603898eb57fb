"""A curved top: the quadratic through it and its vertex."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.pointed import tip_above
from stretch_bt.perception.robust import TUKEY, quantile, scale_of
from stretch_bt.perception.steps import shared_step
from stretch_bt.units import Estimate

__all__ = ["Places", "Points", "Top", "disc_of", "settled"]

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

SCALES = 2  # times that the noise is estimated anew
ROUNDS = 8  # of weights at one scale
CLEARLY = 3.0  # standard deviations at which a top counts as curved
ROUND = 0.02  # difference of a round top's curvature from one direction to another, as a share of it
APART = 14.2  # chi2 of three values with three degrees of freedom beyond which 0.27 % lie, as beyond three standard deviations of one
BLOCK = 0.6  # rms distances of the points from their middle, along a side: a disc has some twenty
EVEN: Array = np.array(
    [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 1]], dtype=float
)


@dataclass(frozen=True, slots=True)
class Points:
    """Points (3, n), m, of an image `wide` pixels wide at the numbers (n,) of their pixels, row by row, and its noise where that is known.

    `every` is 2, 3 ... for points of every second, third ... row and column; `step`, m, is the step in which heights come.
    """

    cloud: Array
    places: Places
    wide: int = 1
    noise: NoiseSpectrum | None = None
    every: int = 1
    step: float = 0.0

    def __len__(self) -> int:
        return int(self.places.size)

    def at(self, chosen: npt.NDArray[np.intp] | npt.NDArray[np.bool_]) -> Points:
        """Return the chosen of the points."""
        return replace(self, cloud=np.ascontiguousarray(self.cloud[:, chosen]), places=self.places[chosen])

    @property
    def least_sd(self) -> float:
        """Standard deviation, m, of one point that no residual may show, as where all heights of a disc are one count."""
        return max(self.noise.white_sd if self.noise is not None else 0.0, self.step / math.sqrt(12.0))

    def step_error(self, sd: float) -> float:
        """Return the standard deviation, m, of the error that all points share since heights come in steps, by that of one residual, m."""
        evens = sd if self.noise is None else min(self.noise.sd_beside_counts(self.step), sd)
        return shared_step(self.step, evens)

    def shared(self, design: Array) -> Array:
        """Return the covariance (k, k), m^2, of sums of the points' noise weighed by `design` (k, n), but for the white part of it."""
        if self.noise is None:
            return np.zeros((len(design), len(design)))
        return self.noise.shared(design, self.places // self.wide, self.places % self.wide, self.every)


def disc_of(cloud: Array) -> tuple[Array, Array, float]:
    """Return the middle (2,) of points (3, n), m, their squared distances (n,) from it, and the radius of a disc that they fill."""
    middle = np.array([quantile(cloud[0]), quantile(cloud[1])])
    x, y = cloud[0] - middle[0], cloud[1] - middle[1]
    away = np.asarray(x * x + y * y)
    return middle, away, math.sqrt(2.0 * quantile(away))


def settled(design: Array, z: Array, least: float = 0.0) -> tuple[Array, float]:
    """Return the parameters (k,) of a robust fit of z (n,) by design (k, n), and the standard deviation of one residual.

    The deviation holds what Tukey's weights cost, so that it goes with the covariance of plain least squares. Weights know no noise
    less than `least`: where most heights are one count of a camera, the few others say where in the count the mean lies.
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
            scale = max(scale_of(residuals, free), least, 1e-12)
            cut, close = TUKEY * scale, 0.01 * scale / math.sqrt(len(z))
    return q, m_sd(residuals, cut, free)


def _misfit(x: Array, y: Array, left: Array, sd: float, points: Points) -> float:
    """Return the rms, m, of the residuals in blocks of a disc beyond noise: the error where the surface is no quadratic."""
    block = np.floor(x / BLOCK).astype(np.intp) * 16 + np.floor(y / BLOCK).astype(np.intp)
    block -= block.min()
    count = np.bincount(block)
    means = np.bincount(block, left)[count > 0] / count[count > 0]
    count = count[count > 0]
    pixels = float(np.mean(count)) * points.every**2
    noise = points.noise
    white = max(sd, noise.white_sd) if noise is not None else sd  # all of a face may lie in one count
    by_chance = white * white / count + (noise.of_mean(pixels) if noise is not None else 0.0)
    return math.sqrt(max(float(np.average(means**2 - by_chance, weights=count)), 0.0))


class Top:
    """z = c + b . (x, y) - (kx x^2 + 2 kxy x y + ky y^2) / 2 about `middle`, fitted with Tukey's weights."""

    def __init__(self, points: Points, middle: Array, *, even: bool) -> None:
        """Fit to points; `even` keeps the curvature the same in all directions."""
        self.middle, cloud = middle, points.cloud
        x, y = cloud[0] - middle[0], cloud[1] - middle[1]
        offset = quantile(cloud[2])
        self.size = max(float(np.sqrt((x @ x + y @ y) / len(x))), 1e-12)
        x, y = x / self.size, y / self.size
        bent = [-0.5 * (x * x + y * y)] if even else [-0.5 * x * x, -x * y, -0.5 * y * y]
        design = np.stack([np.ones_like(x), x, y, *bent])
        self.q, self.sd = settled(design, cloud[2] - offset, points.step)  # `sd` of one point, m
        self._points, self._design, self._left = points, design, cloud[2] - offset - self.q @ design
        self.q[0] += offset
        if even:
            self.q = EVEN @ self.q

    @cached_property
    def misfit(self) -> float:
        """Rms deviation of the surface from a quadratic, m."""
        return _misfit(self._design[1], self._design[2], self._left, self.sd, self._points)

    @cached_property
    def covariance(self) -> Array:
        """Covariance (6, 6) of `q`."""
        gain = np.linalg.inv(self._design @ self._design.T)
        own = gain * (self.sd or self._points.least_sd) ** 2 + gain @ self._points.shared(self._design) @ gain
        return np.asarray(EVEN @ own @ EVEN.T if len(own) < len(EVEN) else own, dtype=np.float64)

    def _sd_along(self, row: Array) -> float:
        """Return the standard deviation of a quantity that changes with `q` like this; rounding may leave less than none."""
        return math.sqrt(max(float(row @ self.covariance @ row), 0.0))

    def bent(self, known: Estimate | None) -> Top:
        """Return it with a curvature, 1/m, known from elsewhere, the same in all directions; or as it is where that clearly does not fit."""
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
    def curvature_sd(self) -> float:
        """Standard deviation of that, 1/m."""
        row = np.array([0.0, 0.0, 0.0, 0.5, 0.0, 0.5])
        return self._sd_along(row) / self.size**2

    @property
    def sag(self) -> Estimate:
        """How far it falls, m, to the rim of a disc; the mean over that is half of this lower than the top."""
        row = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 1.0])
        return Estimate(self.fall, math.hypot(self._sd_along(row) / 2.0, self.misfit))

    @property
    def fall(self) -> float:
        """How far it falls, m, from the middle of a disc to its rim."""
        return float(self.q[3] + self.q[5]) / 2.0

    @property
    def is_convex(self) -> bool:
        """Whether it has a vertex."""
        kx, kxy, ky = self.q[3:].tolist()
        return bool(kx + ky > 0.0 and kx * ky > kxy * kxy)

    def curved_along(self, axis: Array) -> float:
        """Return the convexity along an axis (2,), in standard deviations."""
        x, y = axis.tolist()
        row = np.array([0.0, 0.0, 0.0, x * x, 2.0 * x * y, y * y])
        return float(row @ self.q) / max(self._sd_along(row), 1e-300)

    @property
    def significance(self) -> float:
        """Convexity, in standard deviations, in the direction in which it is least: a vertex along it lies anywhere."""
        kx, kxy, ky = self.q[3:].tolist()
        angle = 0.5 * math.atan2(-2.0 * kxy, ky - kx)
        return self.curved_along(np.array([math.cos(angle), math.sin(angle)]))

    @property
    def is_curved(self) -> bool:
        """Whether it is clearly convex in every direction."""
        return self.significance > CLEARLY

    def _offset(self, most: float) -> Array:
        """Return the vertex from the middle in units of `size`, at most `most` metres away."""
        if most == 0.0:
            return np.zeros(2)
        kx, kxy, ky = self.q[3:]
        step: Array = np.linalg.solve([[kx, kxy], [kxy, ky]], self.q[1:3])
        return step * min(1.0, most / self.size / max(float(np.linalg.norm(step)), 1e-300))

    def vertex(self, most: float) -> Array:
        """Return (x, y) of the vertex, m."""
        return self.middle + self.size * self._offset(most)

    def estimate(self, most: float) -> Estimate:
        """Return the height of the vertex; where it lies does not matter to first order, and to second order noise raises it."""
        x, y = self._offset(most)
        row = np.array([1.0, x, y, -0.5 * x * x, -x * y, -0.5 * y * y])
        sd = self._sd_along(row)
        kx, kxy, ky = self.q[3:]
        raised = 0.5 * float(np.trace(np.linalg.solve([[kx, kxy], [kxy, ky]], self.covariance[1:3, 1:3])))
        return Estimate(float(row @ self.q) - min(max(raised, 0.0), sd), math.hypot(sd, self.misfit))

    def tip(self, most: float) -> Estimate:
        """Return how far a tip stands above the vertex, m; below 0 where the top is flatter than a quadratic."""
        return tip_above(self._design, self.q, self._left, self.sd, self._offset(most), self._points)
