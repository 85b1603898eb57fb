"""A top that lies at the edge of the view, or beyond it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.high_part import clearly_above, means_of, sd_of_mean
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.regions import closed
from stretch_bt.perception.types import FloatArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["check_top_in_view"]

LABELS_END = 24  # pixels from the edge of the view, at most, where labels of a contact end that goes on to it
EDGE = 6  # pixels from the edge of the view, within which a top is not seen from both sides
HOLE = 5  # pixels along a side, of holes that count as seen, and of specks that do not
MARGIN = LABELS_END + EDGE + HOLE
SEEN = 0.3  # least share of a mean's pixels that have depth


def check_top_in_view(
    points: FloatArray, valid: MaskArray, touching: MaskArray, noise: NoiseSpectrum, top: Estimate
) -> None:
    """Raise IllConditioned where the membrane (h, w) rises from a contact to the edge of the view, above `top`, m, or all of it farther in."""
    seen = _around(valid, touching)
    edge = _edge(seen)
    if not edge.any():
        return
    there = _around(touching, touching)
    edge &= _beside(there) & seen
    mean = means_of(_around(points[..., 2], touching), seen, SEEN)
    off = sd_of_mean(noise) / math.sqrt(SEEN)
    above = clearly_above(int(np.count_nonzero(edge)), noise)
    highest = float(np.max(mean, where=edge, initial=-np.inf))
    inner = float(np.max(mean, where=there & ~edge, initial=-np.inf))
    if highest > min(top.value + above * math.hypot(top.sd, off), inner + above * math.sqrt(2.0) * off):
        raise IllConditioned(
            f"the membrane rises towards the edge of the view, to {1e3 * highest:.1f} mm there, so that the top may lie outside of it; move the"
            " hand so that the object is nearer to the middle of the view"
        )


def _around(image: npt.NDArray[Any], touching: MaskArray) -> npt.NDArray[Any]:
    """Return an image (h, w) around a contact, with 0 outside of the view."""
    import cv2

    u, v, w, h = cv2.boundingRect(touching.view(np.uint8))
    spans = [(v - MARGIN, v + h + MARGIN), (u - MARGIN, u + w + MARGIN)]
    beyond = [(max(-first, 0), max(end - n, 0)) for (first, end), n in zip(spans, image.shape, strict=True)]
    (top, bottom), (left, right) = ((max(first, 0), end) for first, end in spans)
    return np.pad(image[top:bottom, left:right], beyond)


def _beside(touching: MaskArray) -> MaskArray:
    """Return the pixels (h, w) that are as near to a contact as labels may end before it does."""
    import cv2

    square = np.ones((2 * LABELS_END + 1, 2 * LABELS_END + 1), dtype=np.uint8)
    return np.asarray(cv2.dilate(touching.view(np.uint8), square) > 0)


def _edge(seen: MaskArray) -> MaskArray:
    """Return the pixels (h, w) that lie at the edge of what is seen; holes amid it have none."""
    import cv2

    square = np.ones((HOLE, HOLE), dtype=np.uint8)
    filled = closed(seen, HOLE).view(np.uint8)
    unseen = 1 - np.asarray(cv2.morphologyEx(filled, cv2.MORPH_OPEN, square))
    _, numbers = cv2.connectedComponents(unseen)
    rim = np.concatenate([numbers[0], numbers[-1], numbers[:, 0], numbers[:, -1]])
    outside = np.isin(numbers, rim[rim > 0])
    wide = np.ones((2 * EDGE + 1, 2 * EDGE + 1), dtype=np.uint8)
    return np.asarray(cv2.dilate(outside.view(np.uint8), wide) > 0)
