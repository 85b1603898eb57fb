"""Gaussian smoothing and derivatives of images with holes, by separable filters."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import quantile
from stretch_bt.perception.types import MaskArray

__all__ = [
    "covered",
    "derivative",
    "enlarge",
    "gain",
    "gaussian",
    "grown",
    "laplacian",
    "least_seen",
    "medians",
    "ready_for_differences",
    "shrink",
    "slope",
    "smooth",
]

Image = npt.NDArray[np.float32]

WIDE = 40.0  # pixels
LESS = 0.08  # of a square, that lacks depth by chance beyond what dropouts take of any square
DIFFERENCES = {1: (-0.5, 0.0, 0.5), 2: (1.0, -2.0, 1.0)}


@lru_cache(maxsize=128)
def gaussian(sigma: float, order: int) -> npt.NDArray[np.float64]:
    """Return a sampled Gaussian derivative (order 0, 1 or 2) that is exact on polynomials of that order.

    `sigma`, at least 0.5, is in pixels, and the filter is meant for correlation, as `cv2.sepFilter2D` does it.
    """
    if order:
        return np.convolve(narrowed(sigma), DIFFERENCES[order])
    return _samples(sigma, math.ceil(3.5 * sigma))


@lru_cache(maxsize=64)
def narrowed(sigma: float) -> npt.NDArray[np.float64]:
    """Return a Gaussian that has `sigma` once a second difference of neighbours, which spreads it by 1/6, is taken."""
    return _samples(math.sqrt(sigma**2 - 1.0 / 6.0), math.ceil(3.5 * sigma) - 1)


def _samples(sigma: float, radius: int) -> npt.NDArray[np.float64]:
    u = np.arange(-radius, radius + 1, dtype=np.float64)
    g = np.exp(-0.5 * (u / sigma) ** 2)
    return np.asarray(g / g.sum())


def ready_for_differences(image: Image, sigma: float) -> Image:
    """Return an image (h, w), smooth, with one pixel more on each side: differences there are as `derivative` has them."""
    import cv2

    kernel = narrowed(sigma)
    larger = cv2.copyMakeBorder(image, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    return np.asarray(cv2.sepFilter2D(larger, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_REPLICATE))


def derivative(image: Image, sigma: float, along_u: int, along_v: int) -> Image:
    """Return the smoothed derivative, per pixel, of a finite image (h, w); beyond its edge it continues constant."""
    import cv2

    row, column = gaussian(sigma, along_u), gaussian(sigma, along_v)
    return np.asarray(
        cv2.sepFilter2D(image, cv2.CV_32F, row, column, borderType=cv2.BORDER_REPLICATE), dtype=np.float32
    )


def laplacian(image: Image, sigma: float) -> Image:
    """Return the sum of both second derivatives, per pixel, as `derivative` has them."""
    import cv2

    return np.asarray(cv2.Laplacian(ready_for_differences(image, sigma), cv2.CV_32F, ksize=1)[1:-1, 1:-1])


def medians(image: Image, seen: MaskArray, wide: int) -> Image:
    """Return the medians of an image (h, w) in squares 3 or 5 pixels wide; what is not seen, which is 0, counts as the mean around it."""
    import cv2

    if not seen.all():
        total, share = (cv2.blur(np.asarray(part, dtype=np.float32), (wide, wide)) for part in (image, seen))
        image = np.where(seen, image, total / np.maximum(share, np.float32(1e-3)))
    return np.asarray(cv2.medianBlur(image, wide))


def least_seen(share: npt.NDArray[Any], least: float, less: float = LESS, part: float = 0.5) -> float:
    """Return the share of a square that must have depth: `least`, or `less` below the share that dropouts leave of such a part of squares."""
    some = share[share > 0.0]
    return min(least, (quantile(some, part) if some.size else 1.0) - less)


def slope(image: Image, axis: int) -> Image:
    """Return central differences, per pixel, of an image that is smooth already; axis 1 is along u, 0 along v."""
    import cv2

    edge = cv2.BORDER_REPLICATE
    difference = cv2.Sobel(image, cv2.CV_32F, axis, 1 - axis, ksize=1, scale=0.5, borderType=edge)
    return np.asarray(difference, dtype=np.float32)


def shrink(image: Image, valid: MaskArray | Image) -> tuple[Image, Image]:
    """Return the mean of the valid pixels in each 2 x 2, or their mean by weights, and the share that is valid.

    The last bins may reach past the edge of the image; where nothing is valid the mean is 0.
    """
    from stretch_bt.perception.surface_kernel import halve

    size = tuple(-(-n // 2) for n in image.shape)
    mean, share = np.empty(size, dtype=np.float32), np.empty(size, dtype=np.float32)
    halve(image, valid, mean, share)
    return mean, share


def enlarge(image: Image, step: int, shape: tuple[int, int]) -> Image:
    """Return an image of bins in pixels, (h, w) of `shape`, by linear interpolation between the middles of the bins."""
    return np.asarray(grown(image, step)[: shape[0], : shape[1]])


def grown(image: Image, step: int) -> Image:
    """Do as `enlarge`, with all pixels of the last bins, in one piece of memory."""
    import cv2

    if step == 1:
        return np.ascontiguousarray(image, dtype=np.float32)
    size = (image.shape[1] * step, image.shape[0] * step)
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_LINEAR), dtype=np.float32)


def smooth(image: Image, weight: Image, sigma: float) -> tuple[Image, Image]:
    """Return the mean of the pixels under a Gaussian by their weight, and the share of the Gaussian that they cover.

    This is normalised convolution (Knutsson and Westin, 1993); where nothing is covered the mean is 0.
    """
    total, cover = covered(image, weight, sigma)
    seen = cover > 1e-3
    total[~seen] = 0.0
    np.divide(total, cover, out=total, where=seen)
    return total, cover


def covered(image: Image, weight: Image, sigma: float) -> tuple[Image, Image]:
    """Return the sum of the pixels under a Gaussian by their weight, and the share of the Gaussian that they cover."""
    import cv2

    kernel = gaussian(sigma, 0)
    total, cover = (
        cv2.sepFilter2D(part, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_CONSTANT)
        for part in (image * weight, weight)
    )
    return np.asarray(total), np.asarray(cover)


@lru_cache(maxsize=256)
def gain(sigma: float, *orders: tuple[int, int, float]) -> float:
    """Return the standard deviation, for unit white noise, of a sum of derivatives (along u, along v, weight)."""
    if (
        sigma > WIDE
    ):  # the same by sums of products along each axis, where the filter itself would be an image of millions
        terms = [(weight, gaussian(sigma, u), gaussian(sigma, v)) for u, v, weight in orders]
        power = sum(w1 * w2 * float(a1 @ a2) * float(b1 @ b2) for w1, a1, b1 in terms for w2, a2, b2 in terms)
        return math.sqrt(max(power, 0.0))
    total: Any = 0.0
    for along_u, along_v, weight in orders:
        total = total + weight * np.outer(gaussian(sigma, along_v), gaussian(sigma, along_u))
    return float(np.sqrt((total**2).sum()))
