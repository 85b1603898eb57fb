"""Depth in coarse counts, as of cameras that count whole millimetres: it is evened out before a contact is looked for, or refused."""

from __future__ import annotations

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.types import FloatArray

__all__ = ["check_evened", "count_of", "even_out"]

MOST = 2e-3  # m, of a count
COARSE = 0.3e-3  # m, of a count, from which slopes of a membrane look like terraces, and most pixels of a face like one height
#: parts of a count that noise must show, drawn numbers included, for terraces not to: where it is alike over less than SHARED pixels, and
#: where over more, a part of which passes for slopes; the camera's own is 0.47 counts then, and some 0.35
ENOUGH, ENOUGH_SHARED, SHARED = 0.62, 0.31, 18.0


def count_of(frame: DepthFrame) -> float:
    """Return the step in which all depths of a frame come, m, which may be many units, as of a frame that was averaged with itself."""
    step = float(np.gcd.reduce(frame.raw.reshape(-1))) * frame.unit
    return step if step <= MOST else frame.unit  # all pixels may lie in a few counts that have a divisor by chance


def even_out(points: FloatArray, count: float, number: int) -> None:
    """Add to the heights of points (h, w, 3), m, one number each, drawn evenly from a count, m, where counts are coarse.

    Noise is estimated from how most pixels differ from their neighbours, which counts hide. The numbers make each count as likely as
    heights about it are (Schuchman, Dither Signals and Their Effect on Quantization Noise, 1964); frames of a `number` have the same.
    """
    if count > COARSE:
        drawn = np.random.default_rng(number % 2**32).random(points.shape[:2], dtype=np.float32)
        points[..., 2] += (drawn - np.float32(0.5)) * np.float32(count)


def check_evened(count: float, noise: float, area: float) -> None:
    """Raise IllConditioned where noise of a pixel, m, alike over `area` pixels, leaves terraces of coarse counts, m."""
    if count > COARSE and noise < count * (ENOUGH if area < SHARED else ENOUGH_SHARED):
        raise IllConditioned(
            f"the camera counts depth in steps of {1e3 * count:g} mm, which its noise does not even out, so that slopes look like terraces and"
            " their treads like faces; give the camera a depth unit of 0.1 mm or less"
        )
