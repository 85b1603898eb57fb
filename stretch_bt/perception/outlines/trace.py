"""The border of a region of pixels as a closed line finer than the pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, NoContact
from stretch_bt.perception.outlines.polyline import Array
from stretch_bt.perception.types import MaskArray

__all__ = ["BLUR", "largest_piece", "trace"]

BLUR = 1.0  # pixels; the least at which stairs no longer show
SPECK = 0.1  # share of the region that may lie in other pieces
FEWEST = 40  # pixels
FAINT, SEEN = (
    0.05,
    0.3,
)  # shares of valid pixels within the blur: below the one nothing is known, below the other little
UNSEEN = 0.1  # share of the border that may run along pixels without depth


def largest_piece(region: MaskArray) -> MaskArray:
    """Return the largest 8-connected piece of a region (h, w).

    Raises
    ------
    IllConditioned
        It has too few pixels, consists of several pieces that are no specks, or is cut by the edge of the image.
    """
    import cv2

    count, pieces, stats, _ = cv2.connectedComponentsWithStats(region.astype(np.uint8))
    sizes = stats[1:, cv2.CC_STAT_AREA]
    if sizes.max(initial=0) < FEWEST:
        raise IllConditioned(
            f"the region has {sizes.max(initial=0)} pixels; an outline needs at least {FEWEST}; move the camera nearer, or press deeper"
        )
    if sizes.max() < (1.0 - SPECK) * sizes.sum():
        raise IllConditioned(
            f"the region is in {count - 1} pieces, the largest with {sizes.max()} of {sizes.sum()} pixels, and an"
            " outline goes around one; label one object at a time"
        )
    piece: MaskArray = np.asarray(pieces == 1 + int(sizes.argmax()))
    if piece[0].any() or piece[-1].any() or piece[:, 0].any() or piece[:, -1].any():
        raise IllConditioned(
            "the edge of the image cuts the region, so that its outline is not closed; move the hand over the middle of the object"
        )
    return piece


def trace(region: MaskArray, valid: MaskArray, blur: float = BLUR) -> Array:
    """Return the outer border (n, 2), pixels u and v, of the largest piece of a region (h, w).

    The line is where the region, blurred by a Gaussian of `blur` pixels without those that are not valid, falls to one half. Raises as
    `largest_piece`, NoContact where no valid pixel is in the region, and IllConditioned where too much of the border runs
    along pixels that are not valid.
    """
    import cv2

    if not (region & valid).any():
        raise NoContact("the region has no pixel: nothing is in contact; press deeper")
    cover, soft = _blurred(valid, blur), _blurred(region & valid, blur)
    level = np.where(cover > FAINT, soft / np.maximum(cover, FAINT), np.float32(0.0)).astype(np.float32)
    piece = largest_piece(level >= 0.5)
    found, _ = cv2.findContours(piece.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    line = max(found, key=len)[:, 0].astype(np.float32)
    if float((_at(cover, line) < SEEN).mean()) > UNSEEN:
        raise IllConditioned(
            "the region ends where the image has no depth, so its border is not seen; keep the whole object on the membrane, in view"
        )
    return np.asarray(_on_level(level, line), dtype=np.float64)


def _blurred(mask: MaskArray, blur: float) -> npt.NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.GaussianBlur(mask.astype(np.float32), (0, 0), blur), dtype=np.float32)


def _at(image: npt.NDArray[Any], line: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return an image at places between its pixels."""
    import cv2

    u, v = np.ascontiguousarray(line.T)
    return np.asarray(cv2.remap(image, u, v, cv2.INTER_LINEAR), dtype=np.float32).ravel()


def _on_level(level: npt.NDArray[np.float32], line: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return places moved along the gradient to where the image is one half, by Newton's method."""
    import cv2

    slopes = [np.asarray(cv2.Sobel(level, cv2.CV_32F, 1 - axis, axis, ksize=3)) / 8 for axis in (0, 1)]
    for _ in range(3):
        rise = np.column_stack([_at(slope.astype(np.float32), line) for slope in slopes])
        steep = np.maximum((rise * rise).sum(axis=1), 1e-4)
        step = ((0.5 - _at(level, line)) / steep)[:, None] * rise
        line = (line + np.clip(step, -0.7, 0.7)).astype(np.float32)
    return line
