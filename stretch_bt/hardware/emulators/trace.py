"""Where a stand-in's arm had the hand, as it went."""

from __future__ import annotations

import threading
from bisect import bisect_right
from collections import deque

from stretch_bt.frames import Pose
from stretch_bt.hardware.simulated.path import Placed, between
from stretch_bt.hardware.simulated.track import Track

__all__ = ["Trace"]

#: at 500 Hz a little more than the second that a camera may look back
_KEPT = 700
#: how far apart, s, a world that has a memory is taken along it
_APART = 0.04
#: nothing is written down of a hand that stands, s
_GAP = 0.05


class Trace(Track[Placed]):
    """A track that is written down pose by pose; between two of them it is straight. Safe to use from any thread."""

    def __init__(self, pose: Pose) -> None:
        super().__init__(Placed(pose, pose))
        self._noted: deque[tuple[float, Placed]] = deque([(float("-inf"), Placed(pose, pose))], maxlen=_KEPT)
        self._lock = threading.Lock()

    def note(self, time: float, told: Pose, true: Pose | None = None) -> None:
        """Write down where the arm says that the hand is at a time, s, later than those before, and where it is, if that is elsewhere."""
        with self._lock:
            self._noted.append((time, Placed(told, true or told)))

    def at(self, time: float) -> Placed:
        """Return the place at a time, s."""
        with self._lock:
            k = bisect_right(self._noted, time, key=lambda noted: noted[0])
            since, before = self._noted[max(k - 1, 0)]
            until, after = self._noted[min(k, len(self._noted) - 1)]
        if not since <= time < until or until - since > _GAP:
            return before
        part = (time - since) / (until - since)
        return Placed(between(before.told, after.told, part), between(before.true, after.true, part))

    def turns(self, after: float, until: float) -> list[float]:
        """Return times in (after, until], s, at least 40 ms apart, at which the hand was seen elsewhere."""
        found: list[float] = []
        with self._lock:
            for time, _ in self._noted:
                if after < time <= until and (not found or time - found[-1] >= _APART):
                    found.append(time)
        return found
