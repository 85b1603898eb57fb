"""Where something was seen to be, as it went: by a stand-in that moves it, or by a real device beside simulated ones."""

from __future__ import annotations

import math
import threading
from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from operator import itemgetter
from typing import TypeVar

from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.simulated.track import Track

__all__ = ["Reported", "Trace"]

T = TypeVar("T")
#: number of poses: at 500 Hz a little more than the second that a camera may look back
_KEPT = 700
#: how far apart, s, a world that has a memory is taken along it
_APART = 0.04


class Trace(Track[T]):
    """A track that is written down place by place; between two of them it is interpolated. Safe to use from any thread.

    Parameters
    ----------
    rest
        Where it is before the first place.
    between
        Returns what lies between two places, at a part from 0 to 1 of the way.
    gap
        Time, s, between two places over which it stood, so that nobody wrote it down.
    """

    def __init__(self, rest: T, between: Callable[[T, T, float], T], gap: float = math.inf) -> None:
        super().__init__(rest)
        self._between = between
        self._gap = gap
        self._noted: deque[tuple[float, T]] = deque([(float("-inf"), rest)], maxlen=_KEPT)
        self._lock = threading.Lock()

    def note(self, time: float, place: T) -> None:
        """Write down where it is at a time, s, later than those before."""
        with self._lock:
            self._noted.append((time, place))

    def at(self, time: float) -> T:
        """Return the place at a time, s."""
        with self._lock:
            k = bisect_right(self._noted, time, key=itemgetter(0))
            since, before = self._noted[max(k - 1, 0)]
            until, after = self._noted[min(k, len(self._noted) - 1)]
        apart = until - since
        if not since <= time < until or apart > self._gap or math.isinf(apart):
            return before
        return self._between(before, after, (time - since) / apart)

    def turns(self, after: float, until: float) -> list[float]:
        """Return times in (after, until], s, at least 40 ms apart, at which it was seen elsewhere."""
        found: list[float] = []
        with self._lock:
            for time, _ in self._noted:
                if after < time <= until and (not found or time - found[-1] >= _APART):
                    found.append(time)
        return found


class Reported(Trace[T]):
    """A trace that a real device writes: its latest reading, whenever somebody asks. Before the first one it was where that says.

    Parameters
    ----------
    read
        Returns the latest reading of the device.
    between
        Returns what lies between two values, at a part from 0 to 1 of the way.
    now
        The time of the simulation, s, which may lag behind the device's time.
    """

    def __init__(
        self, read: Callable[[], Reading[T]], between: Callable[[T, T, float], T], now: Callable[[], float]
    ) -> None:
        reading = read()
        super().__init__(reading.value, between)
        self._read, self._now = read, now
        self._latest = now()
        self.note(self._latest, reading.value)

    def at(self, time: float) -> T:
        """Return the place at a time, s; raises DeviceFault."""
        reading, now = self._read(), self._now()
        if now > self._latest:
            self._latest = now
            self.note(now, reading.value)
        return super().at(time)
