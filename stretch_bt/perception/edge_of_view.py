"""A top that lies at the edge of the view, or beyond it."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.high_part import WIDE, clearly_above, means_of
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.types import FloatArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["check_top_in_view"]

LABELS_END = 24  # pixels from the edge of the view, at most, where labels of a contact end that goes on to it
EDGE = 6  # pixels from the edge of the view, within which a top is not seen from both sides


def check_top_in_view(
    points: FloatArray, valid: MaskArray, touching: MaskArray, noise: NoiseSpectrum, top: Estimate
) -> None:
    """Raise IllConditioned where the membrane (h, w) rises from a contact to the edge of the view, above `top`, m, or all of it farther in."""
    import cv2

    view, contact = _bounds(valid), _bounds(touching)
    close = [abs(a - b) <= LABELS_END for a, b in zip(view, contact, strict=True)]
    if not any(close):
        return
    rows, columns = (
        slice(max(contact[k] - LABELS_END, view[k]), min(contact[k + 1] + LABELS_END, view[k + 1])) for k in (0, 2)
    )
    seen, there = valid[rows, columns], touching[rows, columns]
    mean = means_of(points[rows, columns, 2], seen)
    edge = np.zeros(mean.shape, dtype=bool)
    for at_side, line in zip(close, (edge[:EDGE], edge[-EDGE:], edge[:, :EDGE], edge[:, -EDGE:]), strict=True):
        line |= at_side
    square = np.ones((2 * LABELS_END + 1, 2 * LABELS_END + 1), dtype=np.uint8)
    edge &= np.asarray(cv2.dilate(there.view(np.uint8), square) > 0) & seen
    off = math.sqrt(noise.of_mean(WIDE**2) + noise.white_sd**2 / WIDE**2)
    above = clearly_above(int(np.count_nonzero(edge)), noise)
    highest = float(np.max(mean, where=edge, initial=-np.inf))
    inner = float(np.max(mean, where=there & ~edge, initial=-np.inf))
    if highest > min(top.value + above * math.hypot(top.sd, off), inner + above * math.sqrt(2.0) * off):
        raise IllConditioned(
            f"the membrane rises towards the edge of the view, to {1e3 * highest:.1f} mm there, so that the top may lie outside of it; move the"
            " hand so that the object is nearer to the middle of the view"
        )


def _bounds(mask: MaskArray) -> tuple[int, int, int, int]:
    """Return the first row and column of a mask (h, w) and those after its last: rows, then columns."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1
