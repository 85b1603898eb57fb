"""A positive function of a positive number as a smooth curve through points, in logarithms."""

from __future__ import annotations

import math
from bisect import bisect_right

import numpy as np
import numpy.typing as npt

__all__ = ["PowerCurve", "slopes"]

Array = npt.NDArray[np.float64]


def slopes(x: Array, y: Array) -> Array:
    """Return the slopes (n,) at which a cubic through points (n,) turns only where they do.

    Inside the weighted harmonic mean of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984), 0 where the points turn; at
    the ends the slope between the outermost two.
    """
    step = np.diff(x)
    chord = np.diff(y) / step
    before, after = chord[:-1], chord[1:]
    wide, narrow = 2 * step[1:] + step[:-1], step[1:] + 2 * step[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = (wide + narrow) / (wide / before + narrow / after)
    return np.concatenate([chord[:1], np.where(before * after > 0, inner, 0.0), chord[-1:]])


class PowerCurve:
    """The curve through points x, y (n,), all above 0: cubics of log y over log x, and a power law beyond either end.

    Smooth, with exact derivatives, and rising where the points rise. It is 0 at and below x = 0. One that does not go on keeps
    its last value past its last point.
    """

    def __init__(self, x: Array, y: Array, *, goes_on: bool = True) -> None:
        u, v = np.log(x), np.log(y)
        self._u, self._v, self._slopes = u.tolist(), v.tolist(), slopes(u, v).tolist()
        self._last = 1.0 if goes_on else 0.0

    def __call__(self, x: float) -> tuple[float, float]:
        """Return value and derivative."""
        if x <= 0:
            return 0.0, 0.0
        u = math.log(x)
        v, power = self._logarithm(u)
        value = math.exp(v)
        return value, power * value / x

    def _logarithm(self, u: float) -> tuple[float, float]:
        """Return log y and its slope at log x."""
        knots, logs, slope = self._u, self._v, self._slopes
        k = bisect_right(knots, u) - 1
        if k < 0 or k >= len(knots) - 1:
            end, power = (0, slope[0]) if k < 0 else (-1, self._last * slope[-1])
            return logs[end] + power * (u - knots[end]), power
        step = knots[k + 1] - knots[k]
        t = (u - knots[k]) / step
        rise = (logs[k + 1] - logs[k]) / step
        c2 = 3 * rise - 2 * slope[k] - slope[k + 1]
        c3 = slope[k] + slope[k + 1] - 2 * rise
        return logs[k] + step * t * (slope[k] + t * (c2 + t * c3)), slope[k] + t * (2 * c2 + 3 * t * c3)
