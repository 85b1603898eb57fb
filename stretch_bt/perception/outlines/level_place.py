"""How far a level line as a whole may lie too far out or in: by noise of the heights along it and of the top it counts from, and by the blur."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoContact
from stretch_bt.perception.outlines.outline import Outline, placed
from stretch_bt.perception.pitch import check_square, pitch_of
from stretch_bt.perception.surface import check_points
from stretch_bt.perception.types import FloatArray, MaskArray, SurfaceNoise

__all__ = ["BLUR", "TOP", "blurred", "with_level_errors"]

Array = npt.NDArray[np.float64]

BLUR = 2.5  # pixels, over which noise is averaged; half a millimetre of a surface seen from 200 mm
TOP = 0.5  # per cent of the pixels that count as the top: a disc 8 mm across of a membrane of 100 x 90 mm
LEAST_SLOPE = 0.02  # m/m, below which a level is no line
DRAWS = 4  # draws of noise that show its effect on the top
FIRST = 1.6  # effect of the first blur over the second's: 1 on smooth surfaces, 2.4 at a kink
PIXEL = 0.07  # pixels: error of a line's place from drawing it on a grid


def with_level_errors(outline: Outline, surface: FloatArray, region: MaskArray, noise: SurfaceNoise | None) -> Outline:
    """Return the outline of a region (h, w) above a level, with the errors of its place and its length added to its standard deviations.

    An error of height moves the line by itself over the slope there: where it is alike, all of the line; elsewhere it wriggles, and is too
    long. The blur lowers round places and raises hollow ones: a second blur shows by how much.
    """
    import cv2

    heights, valid = blurred(surface)
    pitch = pitch_of(surface, valid)
    check_square(surface, valid, pitch)
    edge = (cv2.dilate(region.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0) & ~region & valid
    if not edge.any() or pitch == 0.0:
        return outline
    flat = 1.0 / np.maximum(np.hypot(*np.gradient(heights))[edge] / pitch, LEAST_SLOPE)  # m of place by m of height
    again = cv2.GaussianBlur(heights, (0, 0), BLUR) - heights
    bent = FIRST * float(np.mean(again[edge] * flat))
    if noise is None:
        return placed(outline, math.hypot(bent, PIXEL * pitch))
    length = math.sqrt(max(noise.area, 1.0) / (4.0 * math.pi))  # pixels, of the Gaussian that makes noise alike
    wide = math.hypot(BLUR, length)
    sd, steep = noise.sd * length / wide, math.sqrt(float(np.mean(flat**2)))
    alike = sd * math.sqrt(min(2.0 * math.sqrt(math.pi) * wide * pitch / outline.perimeter, 1.0))
    wriggles = outline.perimeter * (math.sqrt(1.0 + 0.5 * (steep * sd / (wide * pitch)) ** 2) - 1.0)
    top = float(np.mean(flat)) * _top_error(heights, valid, sd, wide)
    return placed(outline, math.hypot(bent, PIXEL * pitch, steep * alike, top), wriggles)


def _top_error(heights: Array, valid: MaskArray, sd: float, wide: float) -> float:
    """Return the root mean square, m, of how much noise of a standard deviation, m, and a length, pixels, raises the top.

    Noise is added to heights that have as much already, which raises a flat top by sqrt(2) - 1 of what the first did.
    """
    import cv2

    rng = np.random.default_rng(0)
    told = np.percentile(heights[valid], 100 - TOP)
    moved = []
    for _ in range(DRAWS):
        drawn = cv2.GaussianBlur(rng.standard_normal(heights.shape), (0, 0), wide)
        again = heights + drawn * (sd / max(float(drawn.std()), 1e-12))
        moved.append(float(np.percentile(again[valid], 100 - TOP) - told))
    return math.sqrt(float(np.mean(np.square(moved)))) / (math.sqrt(2.0) - 1.0)


def blurred(surface: FloatArray) -> tuple[Array, MaskArray]:
    """Return heights (h, w), m, blurred as far as pixels are valid, and which are."""
    import cv2

    check_points(surface)
    if not surface.size:
        raise NoContact("the frame has no pixel: nothing is seen; look at the camera")
    heights = surface[..., 2].astype(np.float64)
    valid = np.isfinite(heights)
    weight = cv2.GaussianBlur(valid.astype(np.float64), (0, 0), BLUR)
    total = cv2.GaussianBlur(np.where(valid, heights, 0.0), (0, 0), BLUR)
    return total / np.maximum(weight, 1e-9), valid
