"""The force on a ball whose radius varies, between balls of fixed radii."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.fidelity.curve import Curve
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["Between"]

_RATIO = 1.25  # ratio of one radius to the next; a power of it is within 0.1 % of the force between, but for the jumps of a mesh


class Between:
    """The force on a ball by powers of its radius, so that balls which differ little share their solved presses.

    The balls of fixed radii have a `largest` diameter, m, and parts of it.
    """

    def __init__(self, ball: Sphere, curve: Callable[[Sphere], Curve], largest: float = 1.0) -> None:
        step = math.log(ball.diameter / largest) / math.log(_RATIO)
        low = math.ceil(step) - 1
        self.share = step - low
        self._curves = [curve(Sphere(largest * _RATIO**k)) for k in (low, low + 1)]

    def __call__(self, depth: float) -> tuple[float, float]:
        """Return force along z, N, and slope, N/m, at a depth, m."""
        (a, da), (b, db) = (curve(depth) for curve in self._curves)
        own, other = 1.0 - self.share, self.share
        if min(a, b) <= 0.0:
            return own * a + other * b, own * da + other * db
        force = a**own * b**other
        return force, force * (own * da / a + other * db / b)

    def force(self, depth: float) -> npt.NDArray[np.float64]:
        """Return the force (3,), N, at a depth, m; a part across goes with the force along z."""
        a, b = (curve.force(depth) for curve in self._curves)
        own, other = 1.0 - self.share, self.share
        straight = np.asarray(own * a + other * b)
        if min(a[2], b[2]) <= 0.0:
            return straight
        return straight * (float(a[2] ** own * b[2] ** other) / float(straight[2]))
