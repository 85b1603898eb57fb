"""Gaussian smoothing and derivatives of images with holes, by separable filters."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.types import MaskArray

__all__ = ["derivative", "fill", "gain", "gaussian", "slope", "smooth"]

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


def smooth(image: Image, valid: MaskArray, sigma: float) -> tuple[Image, Image]:
    """Return the mean of the valid pixels under a Gaussian, and the share of the Gaussian that they cover.

    This is normalised convolution (Knutsson and Westin, 1993); where nothing is covered the mean is 0.
    """
    import cv2

    kernel = gaussian(sigma, 0)
    mask = valid.astype(np.float32)
    masked = np.where(valid, image, np.float32(0)).astype(np.float32, copy=False)
    total = cv2.sepFilter2D(masked, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_CONSTANT)
    cover = cv2.sepFilter2D(mask, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_CONSTANT)
    return np.where(cover > 1e-3, total / np.maximum(cover, 1e-3), 0.0).astype(np.float32), np.asarray(cover)


def fill(image: Image, valid: MaskArray, sigma: float) -> tuple[Image, Image]:
    """Return the image with its holes filled by the smoothed neighbourhood, and the cover there is of each pixel."""
    mean, cover = smooth(image, valid, sigma)
    return np.where(valid, image, mean).astype(np.float32, copy=False), cover


def gain(sigma: float, *orders: tuple[int, int, float]) -> float:
    """Return the standard deviation, for unit white noise, of a sum of derivatives (along u, along v, weight)."""
    total: Any = 0.0
    for along_u, along_v, weight in orders:
        total = total + weight * np.outer(gaussian(sigma, along_v), gaussian(sigma, along_u))
    return float(np.sqrt((total**2).sum()))
