"""Which records of a sensor can be believed: one that jumps has to be confirmed, and counts that stand are reported."""

from __future__ import annotations

from stretch_bt.hardware.ati.rdt import Record

__all__ = ["JUMP", "STANDS_AFTER", "Screen"]

#: largest change of force, N, and of torque, N m, from one record to the next
JUMP = (50.0, 5.0)
#: number of jumps in a row, none of which confirms another, that mark a broken sensor
_JUMPS = 3
#: for how long counts may stand while the sensor's cycles go on, s: as long as a force that a motion goes by may be old
STANDS_AFTER = 0.2


class Screen:
    """Looks at each new record of one stream.

    Parameters
    ----------
    counts_per_newton, counts_per_newton_metre
        Counts of the sensor.
    noisy
        Whether no two measurements are alike.
    """

    def __init__(self, counts_per_newton: float, counts_per_newton_metre: float, noisy: bool) -> None:
        force, torque = JUMP
        self._jump = (*[force * counts_per_newton] * 3, *[torque * counts_per_newton_metre] * 3)
        self._noisy = noisy
        self._good: Record | None = None
        self._doubtful: Record | None = None
        self._jumps = 0
        #: the record before, and since when its counts stand, s
        self._latest: Record | None = None
        self._since = 0.0
        self._event: str | None = None

    def event(self) -> str | None:
        """Return, once, the first thing that somebody has to know since this was asked last."""
        event, self._event = self._event, None
        return event

    def take(self, record: Record, arrived: float) -> bool:
        """Return whether a record that arrived at a time, s, can be believed: it is near the last one that was, or near the one before it."""
        self._look_whether_it_stands(record, arrived)
        if self._near(record, self._good) or self._near(record, self._doubtful):
            self._good, self._doubtful, self._jumps = record, None, 0
            return True
        self._doubtful = record
        self._jumps += 1
        if self._jumps >= _JUMPS:
            force, torque = JUMP
            self._note(f"its values jump by more than {force:g} N or {torque:g} N m from record to record")
        return False

    def _near(self, record: Record, other: Record | None) -> bool:
        return other is not None and all(
            abs(one - two) <= most for one, two, most in zip(record.counts, other.counts, self._jump, strict=True)
        )

    def _look_whether_it_stands(self, record: Record, arrived: float) -> None:
        if self._latest is None or record.counts != self._latest.counts or not self._noisy:
            self._since = arrived
        elif arrived - self._since > STANDS_AFTER:
            self._note(
                f"its six values have been the same for {arrived - self._since:.2g} s while its cycles went on; of a sensor "
                "without noise, say `noisy: false` in the cell file"
            )
        self._latest = record

    def _note(self, event: str) -> None:
        self._event = self._event or event
