"""Gaussian smoothing and derivatives of images with holes, by separable filters."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.types import MaskArray

__all__ = ["derivative", "enlarge", "gain", "gaussian", "shrink", "slope", "smooth"]

Image = npt.NDArray[np.float32]


@lru_cache(maxsize=128)
def gaussian(sigma: float, order: int) -> npt.NDArray[np.float64]:
    """Return a sampled Gaussian derivative (order 0, 1 or 2) that is exact on polynomials of that order.

    `sigma` is in pixels, and the filter is meant for correlation, as `cv2.sepFilter2D` does it.
    """
    radius = math.ceil(3.5 * sigma)
    u = np.arange(-radius, radius + 1, dtype=np.float64)
    g = np.exp(-0.5 * (u / sigma) ** 2)
    g /= g.sum()
    if order == 1:
        g = u * g
        g /= g @ u
    elif order == 2:
        spread = float(g @ u**2)
        g = (u**2 - spread) * g
        g *= 2.0 / float(g @ u**2)
    return g


def derivative(image: Image, sigma: float, along_u: int, along_v: int) -> Image:
    """Return the smoothed derivative, per pixel, of a finite image (h, w); beyond its edge it continues constant."""
    import cv2

    row, column = gaussian(sigma, along_u), gaussian(sigma, along_v)
    return np.asarray(
        cv2.sepFilter2D(image, cv2.CV_32F, row, column, borderType=cv2.BORDER_REPLICATE), dtype=np.float32
    )


def slope(image: Image, axis: int) -> Image:
    """Return central differences, per pixel, of an image that is smooth already; axis 1 is along u, 0 along v."""
    import cv2

    edge = cv2.BORDER_REPLICATE
    difference = cv2.Sobel(image, cv2.CV_32F, axis, 1 - axis, ksize=1, scale=0.5, borderType=edge)
    return np.asarray(difference, dtype=np.float32)


def shrink(image: Image, valid: MaskArray, step: int) -> tuple[Image, Image]:
    """Return the mean of the valid pixels in each bin of `step` x `step`, and the share of a bin that is valid.

    The last bins may reach past the edge of the image; where nothing is valid the mean is 0.
    """
    import cv2

    if step == 1:
        return np.where(valid, image, np.float32(0)), valid.astype(np.float32)
    h, w = image.shape
    size = (-(-w // step), -(-h // step))
    padding = (0, size[1] * step - h, 0, size[0] * step - w, cv2.BORDER_CONSTANT)
    padded = cv2.copyMakeBorder(image, *padding, value=0.0)
    mask = cv2.copyMakeBorder(valid.view(np.uint8), *padding, value=0.0)
    total = cv2.resize(cv2.copyTo(padded, mask), size, interpolation=cv2.INTER_AREA)
    share: Image = np.asarray(cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA), dtype=np.float32)
    np.divide(total, share, out=total, where=share > 0.0)
    return np.asarray(total, dtype=np.float32), share


def enlarge(image: Image, step: int, shape: tuple[int, int]) -> Image:
    """Return an image of bins in pixels, (h, w) of `shape`, by linear interpolation between the middles of the bins."""
    import cv2

    size = (image.shape[1] * step, image.shape[0] * step)
    grown = image if step == 1 else cv2.resize(image, size, interpolation=cv2.INTER_LINEAR)
    return np.asarray(grown[: shape[0], : shape[1]], dtype=np.float32)


def smooth(image: Image, weight: Image, sigma: float) -> tuple[Image, Image]:
    """Return the mean of the pixels under a Gaussian by their weight, and the share of the Gaussian that they cover.

    This is normalised convolution (Knutsson and Westin, 1993); where nothing is covered the mean is 0.
    """
    import cv2

    kernel = gaussian(sigma, 0)
    total, cover = (
        cv2.sepFilter2D(part, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_CONSTANT)
        for part in (image * weight, weight)
    )
    seen = cover > 1e-3
    total[~seen] = 0.0
    np.divide(total, cover, out=total, where=seen)
    return np.asarray(total), np.asarray(cover)


@lru_cache(maxsize=256)
def gain(sigma: float, *orders: tuple[int, int, float]) -> float:
    """Return the standard deviation, for unit white noise, of a sum of derivatives (along u, along v, weight)."""
    total: Any = 0.0
    for along_u, along_v, weight in orders:
        total = total + weight * np.outer(gaussian(sigma, along_v), gaussian(sigma, along_u))
    return float(np.sqrt((total**2).sum()))
