"""Noise that whole rows or whole columns of an image share, as cameras that read out line by line have it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["NO_STRIPES", "Stripes", "stripes_of", "without_lines"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]
Places = npt.NDArray[np.intp]

# A fourth difference across the lines leaves nothing of a membrane, nor of noise alike over more than some 2 pixels.
FOURTH: Image = np.array([[1.0, -4.0, 6.0, -4.0, 1.0]], dtype=np.float32)
AROUND = np.ones(FOURTH.shape, dtype=np.uint8)
POWER = float((FOURTH**2).sum())  # that it leaves of independent lines of variance 1
INDEPENDENT = 2.6  # lines of its residual that count as one independent square: 1 + 2 (0.8^2 + 0.4^2 + 0.11^2)
EVERY = 4  # pixels along a line from one that is looked at to the next: they show stripes of a twelfth of white noise
BLOCK = 16  # pixels along a line; what pixels so far apart share, no noise alike over up to some 8 pixels makes
LEAST_BLOCKS, LEAST_LINES = 4, 30
LEAST_SEEN = 0.25  # of a line
CUT = 4.0  # standard deviations of a line past which it is no noise: a straight edge, or a clamp
CLEARLY = 3.0  # standard errors of a variance from which it counts: one in 700 frames without stripes shows some


@dataclass(frozen=True, slots=True)
class Stripes:
    """Variances, m^2, of the errors that all pixels of a row, and all of a column, share; each line has its own."""

    rows: float = 0.0
    columns: float = 0.0

    @property
    def variance(self) -> float:
        """Variance that they add to one pixel, m^2."""
        return self.rows + self.columns

    @property
    def sd(self) -> float:
        """Standard deviation of one pixel by them alone, m."""
        return math.sqrt(self.variance)

    def of_mean(self, pixels: float) -> float:
        """Return the variance, m^2, of the mean of a square of so many pixels."""
        return self.variance / max(math.sqrt(pixels), 1.0)

    def shared(self, design: Array, rows: Places, columns: Places) -> Array:
        """Return the covariance (k, k) of sums of pixels, weighed by `design` (k, n), at rows and columns (n,)."""
        total = np.zeros((len(design), len(design)))
        for variance, lines in ((self.rows, rows), (self.columns, columns)):
            if variance > 0.0:
                sums = np.stack([np.bincount(lines, weights) for weights in design])
                total += variance * (sums @ sums.T)
        return total

    def after(self, sigma: float, *orders: tuple[int, int, float]) -> float:
        """Return the variance of a sum of derivatives (along u, along v, weight), per pixel, after a Gaussian of `sigma` pixels.

        No derivative along a line sees what the line shares.
        """
        across_rows = [(v, weight) for u, v, weight in orders if u == 0]
        across_columns = [(u, weight) for u, v, weight in orders if v == 0]
        return self.rows * _power(sigma, across_rows) + self.columns * _power(sigma, across_columns)


NO_STRIPES = Stripes()


def _power(sigma: float, terms: list[tuple[int, float]]) -> float:
    """Return the variance that sums of derivatives (order, weight) of a Gaussian leave of white noise of variance 1 on a line."""
    return sum(one * other * _product(sigma, a, b) for a, one in terms for b, other in terms)


def _product(sigma: float, a: int, b: int) -> float:
    """Return the integral of the product of two derivatives of a Gaussian, of orders 0, 1 or 2 (by parts, and its moments)."""
    if (a + b) % 2:
        return 0.0
    half = (a + b) // 2
    moment = math.prod(range(1, 2 * half, 2)) / (2.0 * sigma**2) ** half
    return (-1.0) ** ((a - b) // 2) * moment / (2.0 * math.sqrt(math.pi) * sigma)


def stripes_of(height: Image, seen: MaskArray) -> Stripes:
    """Return the stripes of an image of heights (h, w), m, finite, from its pixels that are seen (h, w)."""
    columns = _of_columns(height[::EVERY], seen[::EVERY])
    turned = np.ascontiguousarray(height[:, ::EVERY].T), np.ascontiguousarray(seen[:, ::EVERY].T)
    return Stripes(_of_columns(*turned), columns)


def _of_columns(height: Image, seen: MaskArray) -> float:
    """Return the variance, m^2, that columns share; 0 where that is not clear.

    Noise of single pixels, and noise that neighbours share, is not alike in blocks of a column that do not touch; the mean product of such
    blocks comes from the noise that the whole column shares.
    """
    import cv2

    deep = BLOCK // EVERY
    blocks, wide = len(height) // deep, height.shape[1]
    if blocks < LEAST_BLOCKS or wide < LEAST_LINES:
        return 0.0
    whole = cv2.erode(seen.view(np.uint8), AROUND, borderType=cv2.BORDER_CONSTANT, borderValue=0.0)
    filtered = cv2.filter2D(height, cv2.CV_32F, FOURTH, borderType=cv2.BORDER_REPLICATE)
    left = np.where(whole, filtered, np.float32(0))  # beside pixels that are not seen it may be no number
    count = np.asarray(cv2.reduce(whole[: blocks * deep], 0, cv2.REDUCE_SUM, dtype=cv2.CV_64F))[0]
    lines = np.flatnonzero(count > LEAST_SEEN * blocks * deep)
    if lines.size < LEAST_LINES:
        return 0.0
    total, products = _products(left[: blocks * deep].reshape(blocks, deep, wide).sum(axis=1)[:, lines])
    count = count[lines]
    means = np.abs(total / count)
    noise = means < CUT * MAD_TO_SD * quantile(means)
    products, pairs = products[noise], ((blocks - 1) * (blocks - 2) / blocks**2) * count[noise] ** 2
    all_pairs = max(float(pairs.sum()), 1.0)
    found = float(products.sum()) / all_pairs
    off = products - found * pairs
    error = math.sqrt(INDEPENDENT * float(off @ off)) / all_pairs
    return found / POWER if found > CLEARLY * error else 0.0


def _products(sums: Image) -> tuple[Array, Array]:
    """Return the sum (n,) of the blocks (b, n) of each line, and the sum of the products of all pairs that do not touch, each pair twice."""
    each = sums.astype(np.float64)
    total = each.sum(axis=0)
    own, beside = (np.einsum("bn,bn->n", each[n:], each[: len(each) - n]) for n in range(2))
    return total, np.asarray(total * total - own - 2.0 * beside)


def without_lines(image: FloatArray, seen: MaskArray, stripes: Stripes) -> FloatArray:
    """Return an image (h, w) about 0 less the mean of the pixels seen of each row and column, as far as stripes are there."""
    for axis, variance in ((1, stripes.rows), (0, stripes.columns)):
        if variance > 0.0:
            count = seen.sum(axis=axis, dtype=np.float32, keepdims=True)
            image = image - np.sum(image, axis=axis, where=seen, keepdims=True) / np.maximum(count, np.float32(1))
    return image
