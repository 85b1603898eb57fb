"""The noise of a depth camera, measured on its own images: from pixel to pixel and from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_counts
from stretch_bt.brief import BriefRepr
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.deprojection import depth_of
from stretch_bt.perception.types import FloatArray

__all__ = ["FrameNoise", "PixelNoise", "frame_noise", "pixel_noise"]

Array = npt.NDArray[np.float64]

QUIET = 0.5  # share of the patches, those with least residual, that the correlation is taken from


@dataclass(frozen=True, slots=True, repr=False)
class PixelNoise(BriefRepr):
    """Noise within one image, patch by patch.

    `sd` (n,), m, is the standard deviation of the residual to a quadratic over a patch, and `depth` (n,), m, the patch's distance.
    `correlation` (lags,) is the residual's correlation with itself 1, 2 ... pixels aside, over the quieter half of the patches.
    Errors that are smooth over a patch (distortion, drift) are not in it, and noise correlated over a quarter of a patch or more
    comes out too small and its correlation too short.
    """

    sd: Array
    depth: Array
    correlation: Array


@dataclass(frozen=True, slots=True, repr=False)
class FrameNoise(BriefRepr):
    """Noise from frame to frame of a still scene.

    `sd` (h, w), m, is each pixel's standard deviation about its mean over the frames, NaN where it was not always seen.
    `correlation` (lags,) is a pixel's correlation with itself 1, 2 ... frames later, over all pixels; the share that the
    means take away is added again as if frames were independent.
    """

    sd: FloatArray
    correlation: Array


def pixel_noise(depth: FloatArray | DepthFrame, *, width: int = 15, lags: int = 3) -> PixelNoise:
    """Measure the noise of the pixels of one depth image (h, w), m, or frame.

    Parameters
    ----------
    width : int, pixels
        Side of the square patches; one with an invalid pixel is left out.
    lags : int, pixels
        How far the correlation is followed.

    Raises
    ------
    InvalidInput
        The image is no depth image, or the patches are too small for a quadratic and the lags.
    IllConditioned
        No patch is valid throughout.
    """
    check_counts(1, width=width, lags=lags)
    image, valid = depth_of(depth)
    if width < max(5, 2 * lags):
        raise InvalidInput(f"a patch is at least 5 pixels and twice the lags wide, got {width} and {lags} lags")
    patches, whole = _tiles(image.astype(np.float64), width), _tiles(valid, width).all(axis=(1, 2))
    if not whole.any():
        raise IllConditioned(
            f"no patch of {width} x {width} pixels is valid throughout, so that no noise can be measured;"
            " choose narrower patches, or keep reflections off what is seen"
        )
    flat = patches[whole].reshape(-1, width * width)
    v, u = (np.mgrid[0:width, 0:width].reshape(2, -1) - (width - 1) / 2) / width
    basis = np.linalg.qr(np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=1))[0]
    middle = flat.mean(axis=1)
    flat = flat - middle[:, None]
    residual = flat - (flat @ basis) @ basis.T
    sd = np.sqrt((residual**2).sum(axis=1) / (width * width - 6))
    quiet = residual[sd <= np.quantile(sd, QUIET)].reshape(-1, width, width)
    return PixelNoise(sd, middle, np.array([_beside(quiet, lag) for lag in range(1, lags + 1)]))


def _tiles(image: npt.NDArray[Any], width: int) -> npt.NDArray[Any]:
    """Return the squares (n, width, width) that an image is cut into from its first pixel on."""
    rows, columns = (n // width for n in image.shape)
    cut = image[: rows * width, : columns * width].reshape(rows, width, columns, width)
    return cut.transpose(0, 2, 1, 3).reshape(-1, width, width)


def _beside(residual: Array, lag: int) -> float:
    """Return the correlation of residuals (n, w, w) with those `lag` pixels aside and below."""
    power = float((residual**2).mean())
    if power == 0.0:
        return 0.0
    aside = (residual[:, :, lag:] * residual[:, :, :-lag]).mean()
    below = (residual[:, lag:] * residual[:, :-lag]).mean()
    return float(aside + below) / (2.0 * power)


def _length(given: Any) -> int:
    """Return how many images a list or a stack of them holds; 0 for anything else."""
    images = isinstance(given, Sequence) and not isinstance(given, str)
    return len(given) if images or getattr(given, "ndim", 0) > 0 else 0


def frame_noise(frames: Sequence[FloatArray | DepthFrame], *, lags: int = 5) -> FrameNoise:
    """Measure the noise of depth images (h, w), m, or frames of a still scene.

    Raises
    ------
    InvalidInput
        The frames differ in shape, or are too few for the lags.
    IllConditioned
        No pixel is valid in all frames.
    """
    check_counts(1, lags=lags)
    if _length(frames) < lags + 2:
        raise InvalidInput(f"{lags} lags take at least {lags + 2} frames, got {_length(frames)}")
    images = [depth_of(frame) for frame in frames]
    if len({image.shape for image, _ in images}) > 1:
        raise InvalidInput("frames of one scene have one shape")
    always = np.logical_and.reduce([valid for _, valid in images])
    if not always.any():
        raise IllConditioned(
            "no pixel is valid in all frames, so that none shows how it changes; look whether the scene stood"
            " still, and leave frames without depth out"
        )
    stack = np.stack([image[always] for image, _ in images]).astype(np.float64)
    stack -= stack.mean(axis=0)
    count = len(stack)
    variance = (stack**2).sum(axis=0) / (count - 1)
    sd = np.full(always.shape, np.nan, dtype=np.float32)
    sd[always] = np.sqrt(variance)
    power = float(variance.mean())
    found = [float((stack[k:] * stack[:-k]).mean()) + power / count for k in range(1, lags + 1)]
    return FrameNoise(sd, np.array(found) / power if power > 0.0 else np.zeros(lags))
