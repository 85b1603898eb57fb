"""Depth images of a cap pressed into a membrane, and their possible faults."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import deproject, segment, to_membrane

__all__ = [
    "DISTANCE",
    "EDGE",
    "FLAT",
    "LENS",
    "SATURATED",
    "TOP",
    "H",
    "W",
    "cloud",
    "correlated",
    "frame",
    "half_gone",
    "labels",
    "one_pixel",
    "pixel_places",
    "press",
    "still",
    "with_pixels",
]

Image = npt.NDArray[np.float32]

H, W, F, DISTANCE = 160, 200, 400.0, 0.2
LENS = Intrinsics(F, F, (W - 1) / 2, (H - 1) / 2, W, H)
FLAT: Image = np.full((H, W), DISTANCE, dtype=np.float32)
#: depth that a camera of 1/8 mm a count gives where it is saturated, m
SATURATED = 65535 * 0.125e-3
#: radius of the contact of the usual press, m
EDGE = 20e-3 * float(np.sin(0.5))
_OUTER = 45e-3


def pixel_places() -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Return x (1, w) and y (h, 1) of the pixels on the flat membrane, m."""
    x = (np.arange(W) - LENS.cx)[None, :] / F * DISTANCE
    return x, (np.arange(H) - LENS.cy)[:, None] / F * DISTANCE


def press(
    x0: float = 0.0, y0: float = 0.0, radius: float = 20e-3, angle: float = 0.5, noise: float = 0.2e-3, seed: int = 0
) -> Image:
    """Return the depth (h, w), m, of a cap with a logarithmic skirt that meets it without a kink, on a flat membrane."""
    x, y = pixel_places()
    r = np.hypot(x - x0, y - y0)
    edge = radius * np.sin(angle)
    drop = edge**2 / (radius * np.cos(angle))
    base = drop * np.log(_OUTER / edge)
    skirt = base - drop * np.log(np.maximum(r, 1e-6) / edge)
    cap = base - radius * np.cos(angle) + np.sqrt(np.maximum(radius**2 - r * r, 0.0))
    height = np.where(r < edge, cap, np.maximum(skirt, 0.0))
    return np.asarray(DISTANCE - height + np.random.default_rng(seed).normal(0.0, noise, (H, W)), np.float32)


TOP = DISTANCE - float(press(noise=0.0).min())


def correlated() -> Image:
    """Return noise (h, w), m, that neighbours share over 3 pixels, of 1 mm."""
    from scipy.ndimage import gaussian_filter

    white = np.random.default_rng(0).standard_normal((H, W))
    return np.asarray(gaussian_filter(white, 3.0) * 6 * np.sqrt(np.pi) * 1e-3, np.float32)


def still(count: int) -> list[Image]:
    """Return images of the flat membrane with noise."""
    rng = np.random.default_rng(7)
    return [(FLAT + rng.normal(0.0, 0.2e-3, (H, W))).astype(np.float32) for _ in range(count)]


def with_pixels(image: Image, pixels: dict[tuple[int, int], float]) -> Image:
    """Return an image with some pixels (v, u) changed."""
    image = image.copy()
    for (v, u), value in pixels.items():
        image[v, u] = value
    return image


def one_pixel() -> Image:
    """Return an image in which one pixel has depth."""
    return with_pixels(0 * FLAT, {(80, 100): DISTANCE})


def half_gone() -> Image:
    """Return a press of which the left half dropped out."""
    image = press()
    image[:, :85] = 0.0
    return image


def frame(depth: Image, unit: float = 0.02e-3, **changes: Any) -> DepthFrame:
    """Return an image as a camera gives it."""
    raw = np.where(np.isfinite(depth), np.rint(depth / unit), 0).astype(np.uint16)
    h, w = depth.shape
    return DepthFrame(raw, unit, Intrinsics(F, F, (w - 1) / 2, (h - 1) / 2, w, h), 0.0, 0, DISTANCE, **changes)


def cloud(depth: Image) -> tuple[npt.NDArray[Any], npt.NDArray[np.bool_]]:
    """Return points in the membrane frame and which are valid."""
    points, valid = deproject(depth, LENS)
    return to_membrane(points, DISTANCE), valid


def labels(depth: Image, **options: Any) -> npt.NDArray[np.uint8]:
    """Return the labels of an image."""
    return segment(*cloud(depth), **options)
