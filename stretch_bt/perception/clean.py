"""Flying pixels: single depths that lie off the surface around them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import MAD_TO_SD, quantile, sample
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["far_pixels", "flying_pixels", "median", "without_flying", "without_holes"]

Image = npt.NDArray[np.float32]

BEYOND = np.float32(1e6)  # m, past every depth
CUT = 6.0  # standard deviations from the local median


def median(image: Image, valid: MaskArray, width: int = 5) -> Image:
    """Return the median over `width` x `width` pixels (3 or 5), with holes as `without_holes` fills them."""
    import cv2

    return np.asarray(cv2.medianBlur(without_holes(image, valid), width))


def without_holes(image: Image, valid: MaskArray) -> Image:
    """Return an image (h, w) whose holes hold about the median of the valid pixels around them, or of all where none is near.

    One value for all holes would draw the median of their neighbours towards it, wherever pixels drop out here and there.
    """
    import cv2

    if valid.all():
        return image.astype(np.float32, copy=False)
    if not valid.any():
        return np.zeros(image.shape, dtype=np.float32)
    level = np.float32(quantile(sample(image, valid)))
    whole, holes = image.astype(np.float32), np.nonzero(~valid)
    # Half of the holes of a row lie above everything and half below, in turn, so that they leave the median of the rest where it is.
    count = np.bincount(holes[0])
    number = np.arange(holes[0].size) - (np.cumsum(count) - count)[holes[0]]  # of a hole in its row
    turn = (number + holes[0]) % 2
    whole[holes] = np.where(turn == 1, BEYOND, -BEYOND)
    around = cv2.medianBlur(whole, 5)[holes]
    whole[holes] = np.where(np.abs(around) < BEYOND, around, level)
    return whole


def flying_pixels(height: Image, valid: MaskArray, pitch: float) -> MaskArray:
    """Return where a height (h, w), m, is far from the median of its 5 x 5 neighbours; finite, also in the holes.

    Far is six standard deviations of that difference over the image and more than two pixel pitches, so that neither
    coarse quantisation nor a steep but smooth flank is taken for an outlier.
    """
    import cv2

    return far_pixels(height, np.asarray(cv2.medianBlur(height, 5)), valid, pitch)


def far_pixels(height: Image, around: Image, valid: MaskArray, pitch: float) -> MaskArray:
    """Do as `flying_pixels` by a median `around` that is there already; what both hold in the holes does not count."""
    import cv2

    difference = np.asarray(cv2.absdiff(height, around), dtype=np.float32)
    known = sample(difference, valid)
    sd = MAD_TO_SD * quantile(known) if known.size else 0.0
    far: MaskArray = valid & (difference > np.float32(max(CUT * sd, 2.0 * pitch)))
    return far


def without_flying(points: FloatArray, valid: MaskArray, pitch: float) -> MaskArray:
    """Return which valid points (h, w, 3), m, are no flying pixels; `pitch`, m, is the distance between neighbours in a row."""
    if not valid.any():
        return valid
    z = points[..., 2]
    level = np.float32(quantile(sample(z, valid)))
    return valid & ~flying_pixels(np.where(valid, z, level).astype(np.float32, copy=False), valid, pitch)
