"""Whether something that sticks to the membrane pulls it down."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.arguments import check_kind
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.clean import median
from stretch_bt.perception.pattern import LEARNED, Pattern
from stretch_bt.perception.reference import coarse_rise
from stretch_bt.perception.robust import MAD_TO_SD
from stretch_bt.perception.types import FRAME
from stretch_bt.units import Estimate

__all__ = ["pulled_down"]

KERNEL = 10.0  # pixels of the Gaussian under which a place is low
STEP = 4
APART = 7  # steps, nearly three KERNELs: noise so far apart is independent
SAME = 2e-3  # m, largest difference of two stretches that count as one


def pulled_down(frame: DepthFrame, pattern: Pattern) -> Estimate:
    """Return how far the lowest place of a membrane lies below where it hung freely when the pattern was learned, m.

    `frame`, one or a mean of several, is as the camera sent it less the pattern's error, and of the same stretch within
    2 mm. The lowest of many noisy places is some two standard deviations low; the membrane must not be pressed anywhere.

    Raises
    ------
    InvalidInput
        The frame is of another shape or another stretch, or does not say how far the flat membrane is.
    NoContact
        No place of the membrane is seen.
    IllConditioned
        Too little of it is seen to estimate the noise.
    """
    check_kind("frame", frame, DepthFrame, FRAME)
    check_kind("pattern", pattern, Pattern, LEARNED)
    if frame.raw.shape != pattern.hung.shape or frame.plane_distance is None:
        raise InvalidInput(f"it takes a frame of {pattern.hung.shape} pixels that says how far the flat membrane is")
    if frame.stretch is not None and pattern.stretch is not None and abs(frame.stretch - pattern.stretch) > SAME:
        raise InvalidInput(
            f"how the membrane hung was learned at a stretch of {1e3 * pattern.stretch:.1f} mm, the frame is of "
            f"{1e3 * frame.stretch:.1f} mm: set the stretch of `approach` first"
        )
    known = frame.raw > 0
    deeper = np.where(known, frame.depth - np.float32(frame.plane_distance) - pattern.hung, 0).astype(np.float32)
    mean, trusted = coarse_rise(np.where(known, median(deeper, known), np.float32(0)), known, KERNEL, STEP)
    first, middle, last = (np.s_[k * APART : max(len(mean) - (2 - k) * APART, 0)] for k in range(3))
    bends = (mean[first] - 2 * mean[middle] + mean[last])[trusted[first] & trusted[middle] & trusted[last]]
    if not bends.size:
        raise IllConditioned(
            "too little of the membrane is seen to estimate the noise of its height; keep the whole of it in view, free of"
            " reflections"
        )
    noise = MAD_TO_SD * float(np.median(np.abs(bends - np.median(bends)))) / math.sqrt(6)
    return Estimate(float(mean[trusted].max()), math.hypot(noise, pattern.left))
