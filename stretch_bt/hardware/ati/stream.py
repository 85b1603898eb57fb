"""What comes out of a stream of records that may lose, repeat or reorder them."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.hardware.ati.rdt import Record

__all__ = ["Counters", "Stream"]

_MODULUS = 1 << 32
_HALF = 1 << 31
#: that many older records in a row are a sensor that began anew, not ones that were overtaken
_ANEW = 50


@dataclass(slots=True)
class Counters:
    """How many records came, and how many did not, or not as they should."""

    received: int = 0
    lost: int = 0
    late: int = 0
    repeated: int = 0
    stale: int = 0
    malformed: int = 0


class Stream:
    """Keeps the newest record, and counts what went wrong on the way to it."""

    def __init__(self) -> None:
        self.counters = Counters()
        self.newest: Record | None = None
        self._older = 0

    def restart(self) -> None:
        """Expect numbers from the begin, as after a new request."""
        self.newest = None
        self._older = 0

    @property
    def began_anew(self) -> bool:
        """Whether the numbers went back for good: the sensor was restarted."""
        return self._older >= _ANEW

    def take(self, record: Record) -> bool:
        """Note a record, and return whether it is a new measurement, newer than any before."""
        self.counters.received += 1
        last = self.newest
        if last is None:
            self.newest = record
            return True
        ahead = (record.number - last.number) % _MODULUS
        if ahead == 0:
            self.counters.repeated += 1
            return False
        if ahead >= _HALF:
            self.counters.late += 1
            self.counters.lost -= self.counters.lost > 0  # it was counted when it was overtaken
            self._older += 1
            return False
        self._older = 0
        self.counters.lost += ahead - 1
        self.newest = record
        fresh = record.cycle != last.cycle
        self.counters.stale += not fresh
        return fresh
