"""The steps in which a camera counts depth: how wide they are, and the error of a mean that they leave."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.robust import sparse
from stretch_bt.perception.types import FloatArray

__all__ = ["shared_step", "step_of"]

SOME = 2000  # heights, among which some are neighbours in counts


def step_of(heights: FloatArray, others: FloatArray) -> float:
    """Return the least step, m, between the heights (n,), or between those (m,) of the rest of a frame.

    Raises
    ------
    IllConditioned
        There is one height only.
    """
    some = (sparse(np.asarray(z, dtype=np.float64), SOME) for z in (heights, others))
    levels = np.unique(np.concatenate([z[np.isfinite(z)] for z in some]))
    if levels.size < 2:
        raise IllConditioned(
            "all that is seen has one height to the last digit, so that its error is not seen; look whether the camera sends depth, and"
            " average frames"
        )
    return float(np.diff(levels).min())


def shared_step(step: float, sd: float) -> float:
    """Return the standard deviation, m, of the error that all points share because their heights come in steps, m.

    A height is anywhere within half a step, and noise of `sd`, m, evens that out: the mean error keeps exp(-2 pi^2 sd^2 / step^2) of it
    (the first harmonic of the quantiser; Widrow and Kollar, Quantization Noise, 2008). Past half a step nothing is left.
    """
    if sd >= 0.5 * step:
        return 0.0
    return step / math.sqrt(12.0) * math.exp(-2.0 * (math.pi * sd / step) ** 2)
