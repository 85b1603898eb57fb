"""When ticks are due, and their numbers."""

from __future__ import annotations

import math

__all__ = ["TickGrid"]

_ROUNDING = 1e-9


class TickGrid:
    """Deadlines on multiples of a period, and the number of the latest tick.

    A run has its own. Calls on an open cell share one: a call that begins before the next tick is due belongs to the tick in which the one before
    ended, as the next child of a sequence does.

    Parameters
    ----------
    period
        Time between two ticks, s.
    """

    def __init__(self, period: float) -> None:
        self.period = period
        #: number of the latest tick
        self.ticks = 0
        self._origin = 0.0
        self._slot = 0  # of the next tick
        self._ticked: int | None = None  # slot of the latest tick
        self._joined = 0.0  # how long after its deadline a run joined the grid, s

    @property
    def due(self) -> float:
        """When the next tick is due, s; not a sum, whose rounding grows."""
        return self._origin + self._slot * self.period

    def begin(self, now: float) -> None:
        """Let the next tick be due now, s, and those after it count from it."""
        self._origin, self._slot, self._ticked, self._joined = now, 0, None, 0.0

    def join(self, now: float) -> None:
        """Let the next tick be due now, s, and those after it on the grid of the ticks before."""
        if self._ticked is None or self.period <= 0:
            self.begin(now)
            return
        self._slot = max(math.floor((now - self._origin) / self.period + _ROUNDING), self._ticked)
        self._joined = max(now - self.due, 0.0)

    def take(self) -> int:
        """Begin the tick that is due, and return its number."""
        if self._slot != self._ticked:
            self.ticks += 1
        self._ticked = self._slot
        return self.ticks

    def leave(self, now: float) -> float:
        """End a tick at a time, s, and return how late the next one is then; missed ticks are not caught up with."""
        self._slot += 1
        late = now - self.due - self._joined
        if now > self.due and self.period > 0:
            self._slot += int((now - self.due) / self.period + 1)
        self._joined = 0.0
        return late if self.period > 0 else 0.0
