"""Noise that pixels share over several lengths at once."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.stripes import NO_STRIPES, Stripes
from stretch_bt.perception.surface import Surface

__all__ = ["NoiseSpectrum"]

Array = npt.NDArray[np.float64]

MOSTLY_COUNTS = 1.3  # of the variance of counts, below which there is hardly other noise
CELLS = 1.5  # cells in a length, in which its correlation is summed
FEWEST = 0.5  # the same where that would take more than MOST_CELLS
MOST_CELLS = 20_000  # as of a contact 140 pixels across: beyond, its edge is a small part of it


@dataclass(frozen=True, slots=True)
class NoiseSpectrum:
    """Noise of one pixel as a sum of parts: variances (k,), m^2, each shared over a length (k,), pixels, 0 where white.

    A part is white noise after a Gaussian of its length, so that pixels d apart correlate as exp(-d^2 / 4 length^2). Whole rows and
    columns share `stripes` besides.
    """

    variances: Array
    lengths: Array
    stripes: Stripes = NO_STRIPES

    @property
    def area(self) -> float:
        """How many pixels share one error, at least 1; stripes are left aside."""
        total = float(self.variances.sum())
        areas = np.maximum(4.0 * math.pi * self.lengths**2, 1.0)
        return float(self.variances @ areas) / total if total > 0.0 else 1.0

    @property
    def variance(self) -> float:
        """Variance of one pixel, m^2."""
        return float(self.variances.sum()) + self.stripes.variance

    @property
    def shared_area(self) -> float:
        """How many pixels share one error of all parts but the white, at least 1."""
        shared = self.variances * (self.lengths > 0.0)
        return NoiseSpectrum(shared, self.lengths).area if shared.any() else 1.0

    @property
    def shared_sd(self) -> float:
        """Standard deviation, m, of all parts but the white."""
        return math.sqrt(float(self.variances @ (self.lengths > 0.0)))

    @property
    def white_sd(self) -> float:
        """Standard deviation, m, of the white part."""
        return math.sqrt(float(self.variances @ (self.lengths == 0.0)))

    def sd_beside_counts(self, step: float) -> float:
        """Return the standard deviation, m, of the noise without the part that steps of height, m, cause."""
        return math.sqrt(max(self.variance - step**2 / 12.0, 0.0))

    def beside_counts(self, step: float) -> NoiseSpectrum:
        """Return it as white noise where steps, m, alone cause it: they follow the surface, and only seem to be shared."""
        total = self.variance
        alone = total < MOSTLY_COUNTS * step**2 / 12.0
        return NoiseSpectrum(np.array([total]), np.zeros(1)) if alone else self

    def after(self, surface: Surface, *orders: tuple[int, int, float]) -> float:
        """Return the standard deviation, m, of a sum of derivatives (along u, along v, weight) per bin of a smoothed surface."""
        parts = zip(np.sqrt(self.variances), self.lengths, strict=True)
        each = [
            replace(surface, noise=float(sd), length=float(length), stripes=NO_STRIPES) for sd, length in parts if sd
        ]
        lines = replace(surface, noise=0.0, length=0.0, stripes=self.stripes)
        return math.hypot(*(part.noise_after(*(orders or ((0, 0, 1.0),))) for part in [*each, lines]))

    def of_mean(self, pixels: float) -> float:
        """Return the variance, m^2, of the mean of a block of so many pixels, of all parts but the white."""
        areas = 4.0 * math.pi * self.lengths**2
        local = float((self.variances * np.minimum(areas / pixels, 1.0)) @ (areas > 0.0))
        return local + self.stripes.of_mean(pixels)

    def shared(self, design: Array, rows: npt.NDArray[np.intp], columns: npt.NDArray[np.intp], every: int = 1) -> Array:
        """Return the covariance (k, k) of sums of pixels, weighed by `design` (k, n), at rows and columns (n,), of all parts but the white.

        `every` is 2, 3 ... where the pixels are of every second, third ... row and column.
        """
        total = self.stripes.shared(design, rows, columns)
        for variance, length in zip(self.variances, self.lengths, strict=True):
            if variance > 0.0 and length > 0.0:
                total += variance * _alike(design, rows, columns, float(length), every)
        return total


def _alike(
    design: Array, rows: npt.NDArray[np.intp], columns: npt.NDArray[np.intp], length: float, every: int
) -> Array:
    """Return the sums over all pairs of pixels of their weights and correlation exp(-d^2 / 4 length^2), (k, k)."""
    import cv2

    from stretch_bt.perception.noise_spectrum_kernel import fill_cells

    sides = tuple(int(np.ptp(places)) + 1 for places in (rows, columns))
    step = every * max(1, int(length / CELLS / every))
    if sides[0] * sides[1] > MOST_CELLS * step**2:
        step = every * max(1, int(length / FEWEST / every))
    reach = math.ceil(5.0 * length / step)
    kernel = np.exp(-((np.arange(-reach, reach + 1) * step / length) ** 2) / 4.0)
    h, w = ((side - 1) // step + 1 for side in sides)
    summed, blurred = np.zeros((len(design), h, w)), np.empty((len(design), h, w))
    fill_cells(design, rows, columns, step, summed)
    for image, found in zip(summed, blurred, strict=True):
        cv2.sepFilter2D(image, cv2.CV_64F, kernel, kernel, dst=found, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(summed.reshape(len(design), -1) @ blurred.reshape(len(design), -1).T)
