"""Clocks: the machine's own, a virtual one, one that stands still in a tick, and one that repeats the ticks of a record.

All count seconds from 0.
"""

from __future__ import annotations

import threading
import time
from bisect import bisect_right
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from operator import itemgetter
from typing import Protocol

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.plain_numbers import is_number

__all__ = ["Clock", "EndOfRecord", "MixedClock", "PacedClock", "RealClock", "ReplayClock", "VirtualClock"]

#: the longest sleep, s: a signal that arrives as a sleep begins, or that another thread catches, does not end it
LONGEST = 0.05
#: lateness of a sleep that the next wait makes up for, s; a machine at rest stays below a tenth of it
JITTER = 0.01
_ROUNDING = 1e-9
#: marks of a mixed clock that are kept, two a tick; no reading is as old
_MARKS = 1000


class EndOfRecord(Exception):
    """A record has no further ticks."""


class Clock(Protocol):
    """The source of time for the runner and the simulated devices."""

    def now(self) -> float:
        """Return the time, s."""
        ...

    def wait_until(self, deadline: float) -> None:
        """Return at the deadline, s, or earlier when woken."""
        ...

    def reached(self, deadline: float) -> bool:
        """Return whether the wait for a deadline, s, is over."""
        ...

    def wake(self) -> None:
        """End a wait at once; may be called from a signal handler or another thread."""
        ...


class RealClock:
    """The machine's monotonic clock."""

    def __init__(self) -> None:
        self._start = time.monotonic()
        # held except while a wake is pending; an Event may deadlock when a signal handler sets it
        self._asleep = threading.Lock()
        self._asleep.acquire()

    def now(self) -> float:
        """Return the time since the clock was made, s."""
        return time.monotonic() - self._start

    def wait_until(self, deadline: float) -> None:
        """Sleep until the deadline, s, or until woken, and at most for a moment; whoever waits asks again."""
        remaining = deadline - self.now()
        if remaining > 0:
            self._asleep.acquire(timeout=min(remaining, LONGEST))

    def reached(self, deadline: float) -> bool:
        """Return whether it is that late."""
        return self.now() >= deadline - _ROUNDING

    def wake(self) -> None:
        """End the wait."""
        with suppress(RuntimeError):  # it was woken before
            self._asleep.release()


class VirtualClock:
    """A clock that stands still until a caller moves it on: runs are fast and repeat exactly."""

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        """Return the virtual time, s."""
        return self._now

    def wait_until(self, deadline: float) -> None:
        """Jump to the deadline, s; never back."""
        self._now = max(self._now, deadline)

    def reached(self, deadline: float) -> bool:
        """Return whether it is that late."""
        return self.now() >= deadline - _ROUNDING

    def advance(self, seconds: float) -> None:
        """Go on by some seconds; raises InvalidInput unless they are a number from 0 on."""
        if not (is_number(seconds) and seconds >= 0):
            raise InvalidInput(f"a clock goes on by a number of seconds from 0 on, not {shown(seconds)}")
        self.wait_until(self._now + float(seconds))

    def wake(self) -> None:
        """Nothing waits on a virtual clock."""


class PacedClock:
    """Lets a virtual clock go no faster than the machine's, for code that counts the machine's time beside it.

    It is never ahead of the machine, and time that a tick took beyond its period is not caught up with, but for the little delay at
    the end of a sleep.
    """

    def __init__(self, paced: VirtualClock) -> None:
        self.paced = paced
        self._machine = RealClock()
        self._since: float | None = None  # the machine's time at which this clock had come to its own

    def wait_until(self, deadline: float) -> None:
        """Go to the deadline, s, once the machine's clock has gone on by as much, or return earlier when woken."""
        if self._since is None:  # time from before, such as the opening of devices, is not caught up with
            self._since = self._machine.now()
        due = self._since + max(deadline - self.now(), 0.0)
        self._machine.wait_until(due)
        if self._machine.reached(due):
            self._since = max(due, self._machine.now() - JITTER)
            self.paced.wait_until(deadline)

    def now(self) -> float:
        """Return the virtual time, s."""
        return self.paced.now()

    def reached(self, deadline: float) -> bool:
        """Return whether it is that late."""
        return self.paced.reached(deadline)

    def wake(self) -> None:
        """End the wait."""
        self._machine.wake()


class MixedClock(PacedClock):
    """The clock of simulated devices beside real ones: it stands still while a tick is computed, and lags behind the machine's from then on.

    A tick may take a simulation longer than a reading may be old, and the simulated scene must not go on meanwhile without being looked at.
    Real devices go by the machine's clock, `machine`.
    """

    def __init__(self) -> None:
        super().__init__(VirtualClock())
        #: (time of the machine's clock, time of this one) at the begin and the end of waits, between which both go on
        self._marks: deque[tuple[float, float]] = deque(maxlen=_MARKS)
        self._mark()

    @property
    def machine(self) -> RealClock:
        """The clock of the real devices."""
        return self._machine

    def wait_until(self, deadline: float) -> None:
        """Go to the deadline, s, once the machine's clock has gone on by as much, or return earlier when woken."""
        self._mark()
        super().wait_until(deadline)
        self._mark()

    def follow(self, longest: float) -> None:
        """Go on with the machine's clock, by `longest`, s, at most; for callers that tick at their own times."""
        now = self._machine.now()
        elapsed = longest if self._since is None else now - self._since
        self._marks.append((max(now - min(max(elapsed, 0.0), longest), self._marks[-1][0]), self.now()))
        self.paced.advance(min(max(elapsed, 0.0), longest))
        self._since = now
        self._mark()

    def of_machine(self, time: float) -> float:
        """Return the time of this clock at a time of the machine's, s."""
        after = bisect_right(self._marks, time, key=itemgetter(0))
        if after == len(self._marks):
            return self.now()
        if after == 0:
            return self._marks[0][1] - (self._marks[0][0] - time)
        (one, start), (other, end) = self._marks[after - 1], self._marks[after]
        return start + (end - start) * (time - one) / (other - one) if other > one else end

    def _mark(self) -> None:
        self._marks.append((self._machine.now(), self.now()))


class ReplayClock:
    """Gives each tick the time that it had in a record."""

    def __init__(self, times: Sequence[float]) -> None:
        self._times = list(times)
        self._next = 0
        self._now = 0.0

    def now(self) -> float:
        """Return the recorded time of this tick, s."""
        return self._now

    def wait_until(self, deadline: float) -> None:
        """Go to the next recorded tick; raises EndOfRecord after the last."""
        if self._next >= len(self._times):
            raise EndOfRecord
        self._now = self._times[self._next]
        self._next += 1

    def reached(self, deadline: float) -> bool:
        """Return that it is: a tick comes when it came, whatever deadline it would have had here."""
        return True

    def wake(self) -> None:
        """Nothing waits on a record."""
