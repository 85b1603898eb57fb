"""A time that runs from one tick on, counted in ticks: sums of fractions of a second end a tick late by their rounding."""

from __future__ import annotations

import math

from stretch_bt.tree.context import Context

__all__ = ["Countdown"]

#: part of a period that is rounding, not time
_ROUNDING = 1e-6
#: ticks, more than any run has
_MOST = 1e15


class Countdown:
    """Begins at the present tick.

    Parameters
    ----------
    context
        The run.
    seconds
        How long it lasts, s; it is over at the first tick that comes so long after the present one.
    """

    def __init__(self, context: Context, seconds: float) -> None:
        self._context = context
        period = context.period
        self._last = context.slot + (math.ceil(min(seconds / period, _MOST) - _ROUNDING) if period > 0 else 0)
        self._until = context.now + seconds

    @property
    def over(self) -> bool:
        """Whether the time has passed."""
        if self._context.period > 0:
            return self._context.slot >= self._last
        return self._context.now >= self._until
