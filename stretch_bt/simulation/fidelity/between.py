"""The force on a ball whose radius varies, between balls of fixed radii."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.fidelity.curve import Curve
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["Between"]

_RATIO = 1.5  # ratio of one radius to the next; between them the force, about its root, is straight to within 1.5e-3


class Between:
    """The force on a ball by straight lines in its radius, so that balls which differ little share their solved presses."""

    def __init__(self, ball: Sphere, curve: Callable[[Sphere], Curve]) -> None:
        step = math.log(ball.diameter) / math.log(_RATIO)
        low = math.floor(step)
        ends = [_RATIO**k for k in (low, low + 1)]
        self.share = (ball.diameter - ends[0]) / (ends[1] - ends[0])
        self._curves = [curve(Sphere(end)) for end in ends]

    def __call__(self, depth: float) -> tuple[float, float]:
        """Return force along z, N, and slope, N/m, at a depth, m."""
        (a, da), (b, db) = (curve(depth) for curve in self._curves)
        return a + self.share * (b - a), da + self.share * (db - da)

    def force(self, depth: float) -> npt.NDArray[np.float64]:
        """Return the force (3,), N, at a depth, m."""
        a, b = (curve.force(depth) for curve in self._curves)
        return np.asarray(a + self.share * (b - a))
