"""What comes out of a stream of records that may lose, repeat or reorder them."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.hardware.ati.rdt import Record

__all__ = ["RecordCounters", "Stream", "ahead"]

_MODULUS = 1 << 32
_HALF = 1 << 31
#: number of older records in a row that mark a sensor that began anew, not records that were overtaken
_ANEW = 10


@dataclass(slots=True)
class RecordCounters:
    """How many records came, and how many did not, or not as they should."""

    received: int = 0
    lost: int = 0
    late: int = 0
    repeated: int = 0
    stale: int = 0
    malformed: int = 0
    wild: int = 0


class Stream:
    """Keeps the newest record, and counts what went wrong on the way to it.

    A record without a higher number but with a later cycle of the sensor begins a new stream, as after a new request; one with both
    lower was overtaken, unless it is one of many in a row.
    """

    def __init__(self) -> None:
        self.counters = RecordCounters()
        self.newest: Record | None = None
        self._older = 0
        self._back = False

    @property
    def began_anew(self) -> bool:
        """Whether its own cycles went back: the sensor was restarted."""
        return self._back or self._older >= _ANEW

    def go_on(self) -> None:
        """Go on with the next record, whatever its number."""
        self.newest, self._older, self._back = None, 0, False

    def take(self, record: Record) -> bool:
        """Note a record, and return whether it is a new measurement, newer than any before."""
        self.counters.received += 1
        last = self.newest
        if last is None:
            self.newest = record
            return True
        on, later = ahead(record.number, last.number), ahead(record.cycle, last.cycle)
        if on <= 0 and later <= 0:
            return self._overtaken() if on else self._repeated()
        self.counters.lost += max(on - 1, 0)
        self.counters.stale += later == 0
        self._back = later < 0
        self._older = 0
        self.newest = record
        return later > 0

    def _repeated(self) -> bool:
        self.counters.repeated += 1
        return False

    def _overtaken(self) -> bool:
        self.counters.late += 1
        self.counters.lost -= self.counters.lost > 0  # it was counted when it was overtaken
        self._older += 1
        return False


def ahead(number: int, before: int) -> int:
    """Return how far a number of 32 bits is ahead of another, across the turn to 0; negative when it is behind."""
    return (number - before + _HALF) % _MODULUS - _HALF
