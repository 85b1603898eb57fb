"""By how many cycles of the sensor its records follow each other."""

from __future__ import annotations

from stretch_bt.hardware.ati.rdt import Record
from stretch_bt.hardware.ati.stream import ahead

__all__ = ["Pace"]

#: records over which the pace is taken
_BLOCK = 32
#: what a block may differ by: cycles, for records that are due between two of them; records, for one that the sensor puts off; and a part
_CYCLES, _RECORDS, _PART = 2.0, 1.0, 0.1


class Pace:
    """Tells when cycles no longer follow the records as they did: when a cycle number jumps ahead, or the sensor changes its rate.

    Delays on the way change neither number, so times of arrival cannot tell a jump from a delay, and both numbers together can.
    """

    def __init__(self) -> None:
        self._before: Record | None = None
        self._records = self._cycles = 0
        #: cycles a record, of the block before
        self._pace: float | None = None

    def broke(self, record: Record) -> bool:
        """Note a new measurement, and return whether its cycle is not that of its number; then the pace is taken anew."""
        before, self._before = self._before, record
        if (
            before is None or (records := ahead(record.number, before.number)) <= 0
        ):  # another stream, after a new request
            return False
        self._records += records
        self._cycles += ahead(record.cycle, before.cycle)
        if self._pace is not None and abs(self._cycles - self._pace * self._records) > self._most(self._pace):
            self._pace, self._records, self._cycles = None, 0, 0
            return True
        if self._records >= _BLOCK:
            self._pace, self._records, self._cycles = self._cycles / self._records, 0, 0
        return False

    def _most(self, pace: float) -> float:
        return _CYCLES + pace * (_RECORDS + _PART * self._records)
