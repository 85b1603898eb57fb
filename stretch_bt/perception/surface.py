"""A depth image made ready for differentiation: heights towards the camera, holes filled, scale and noise known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.clean import flying_pixels
from stretch_bt.perception.robust import MAD_TO_SD, sparse
from stretch_bt.perception.smooth import derivative, fill, gain, gaussian, slope, smooth
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["Surface", "camera_side", "check_points", "surface_of"]

Image = npt.NDArray[np.float32]

CAMERA_RATIO = 0.4  # distance over width: a camera frame is above it up to a field of view of 100 degrees
COVER = 0.5  # share of the kernel that must see valid pixels
ONE_SIDED = 0.08  # how fast that share may change over a kernel's width: 1.8 widths away from a straight edge


@dataclass(frozen=True, slots=True)
class Surface:
    """Height towards the camera (h, w), m, from `level`, with its holes filled and flying pixels removed.

    `trusted` marks pixels with valid ones on all sides, so that derivatives of `sigma` pixels mean something; `noise` is
    the standard deviation of one pixel, m; `x_u` and `y_v` are the metres that x and y move a pixel; `towards` is +1
    where z points to the camera (membrane frame), -1 where away (camera frame).
    """

    height: Image
    smooth: Image
    valid: MaskArray
    trusted: MaskArray
    x_u: Image
    y_v: Image
    level: float
    pitch: float
    sigma: float
    noise: float
    towards: int

    @property
    def smooth_sd(self) -> float:
        """Standard deviation of the smoothed height, m, if the noise is white."""
        return self.noise * gain(self.sigma, (0, 0, 1.0))


def check_points(points: FloatArray, valid: MaskArray) -> None:
    """Raise InvalidInput unless points are (h, w, 3) floats and valid is (h, w) bool."""
    if points.ndim != 3 or points.shape[2] != 3 or points.dtype.kind != "f":
        raise InvalidInput(f"points are (h, w, 3) floats in m, got {points.dtype} {points.shape}")
    if valid.shape != points.shape[:2] or valid.dtype != np.bool_:
        raise InvalidInput(f"valid is a bool mask of shape {points.shape[:2]}, got {valid.dtype} {valid.shape}")


def camera_side(points: FloatArray, valid: MaskArray) -> int:
    """Return +1 where z points towards the camera, -1 where away from it.

    In the camera frame every z is the distance, comparable to the width that is seen; in the membrane frame z is an
    indentation, small beside that width. A sample of the pixels decides.
    """
    step = max(1, round((valid.size / 20000) ** 0.5))
    seen = points[::step, ::step][valid[::step, ::step]]
    if len(seen) < 2:
        return 1
    width = float(np.ptp(seen[:, :2], axis=0).max())
    return -1 if float(np.median(seen[:, 2])) > CAMERA_RATIO * width else 1


def pitch_of(points: FloatArray, valid: MaskArray) -> float:
    """Return the median distance, m, between neighbours in a row; 0 where no two valid pixels touch."""
    pairs = valid[:, 1:] & valid[:, :-1]
    steps = np.abs((points[:, 1:, 0] - points[:, :-1, 0])[pairs])
    return float(np.median(sparse(steps))) if steps.size else 0.0


def surface_of(points: FloatArray, valid: MaskArray, kernel: float) -> Surface | None:
    """Prepare points (h, w, 3), m, for derivatives with a Gaussian of `kernel`, m; None where too few are valid."""
    check_points(points, valid)
    pitch = pitch_of(points, valid)
    if pitch == 0.0:
        return None
    towards = camera_side(points, valid)
    sigma = float(np.clip(round(kernel / pitch, 1), 1.5, 25.0))
    level = float(np.median(sparse(points[..., 2][valid])))
    raw = (towards * (points[..., 2] - level)).astype(np.float32)
    kept = valid & ~flying_pixels(raw, valid, pitch)
    height, cover = fill(raw, kept, sigma)
    smoothed = derivative(height, sigma, 0, 0)
    trusted = (cover > COVER) & (sigma * _steepness(cover) < ONE_SIDED)
    x_u = _steps(points[..., 0], kept, 1, sigma, pitch)
    y_v = _steps(points[..., 1], kept, 0, sigma, pitch)
    noise = _noise(height - smoothed, kept, sigma)
    return Surface(height, smoothed, kept, trusted, x_u, y_v, towards * level, pitch, sigma, noise, towards)


def _steps(values: Any, valid: MaskArray, axis: int, sigma: float, pitch: float) -> Image:
    """Return how far x (axis 1) or y (axis 0) moves a pixel, m, averaged over the kernel; `pitch` where unseen."""
    first, second = (slice(None, -1), slice(1, None))
    lower, upper = ((slice(None), first), (slice(None), second)) if axis == 1 else ((first,), (second,))
    both = np.zeros(valid.shape, dtype=bool)
    both[lower] = valid[lower] & valid[upper]
    steps = np.zeros(valid.shape, dtype=np.float32)
    steps[lower] = values[upper] - values[lower]
    mean, cover = smooth(steps, both, sigma)
    return np.where((cover > 1e-3) & (np.abs(mean) > 0.1 * pitch), mean, np.float32(pitch))


def _steepness(cover: Image) -> Image:
    """Return the larger gradient of an image along its axes, per pixel."""
    return np.maximum(np.abs(slope(cover, 1)), np.abs(slope(cover, 0)))


def _noise(residual: Any, valid: MaskArray, sigma: float) -> float:
    """Return the noise of one pixel, m, from what the smoothing took away; robust to edges."""
    values = sparse(np.abs(residual[valid]))
    taken = gain(sigma, (0, 0, 1.0)) ** 2 - 2.0 * float(gaussian(sigma, 0).max()) ** 2 + 1.0
    return MAD_TO_SD * float(np.median(values)) / float(np.sqrt(taken))
