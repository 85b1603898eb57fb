"""How long a record was on its way, from the sensor's own cycles and this machine's clock."""

from __future__ import annotations

from bisect import bisect_right

__all__ = ["Delay"]

_MODULUS = 1 << 32
#: how long a corner of the hull counts, s: clocks change their rate with temperature
_KEPT = 300.0
#: how long a stream must have gone on before a record counts as late, s
_KNOWN = 1.0


class Delay:
    """Compares the cycles of one stream with a clock.

    Times of arrival over cycles lie above a line, on which those are that were quickest. The line is the edge of their lower convex hull
    that spans the middle of the stream, which leaves the least sum of delays (Moon, Skelly and Towsley, INFOCOM 1999). How long the
    quickest was on its way is not known, and counts as 0.
    """

    def __init__(self) -> None:
        #: corners of the hull: cycle, counted past its turn to 0, and time of arrival, s
        self._cycles: list[int] = []
        self._times: list[float] = []
        self._began = 0.0

    def take(self, cycle: int, arrived: float) -> float:
        """Return for how long a record was on its way, s, from its cycle's number and its time of arrival, s.

        It is 0 for a cycle that is not later than the ones before, and in the first second.
        """
        if not self._cycles:
            self._began = arrived
            self._append(cycle, arrived)
            return 0.0
        cycle = self._cycles[-1] + (cycle - self._cycles[-1] + _MODULUS // 2) % _MODULUS - _MODULUS // 2
        if cycle <= self._cycles[-1]:
            return 0.0
        self._append(cycle, arrived)
        if arrived - self._began < _KNOWN:
            return 0.0
        while len(self._times) > 2 and self._times[1] < arrived - _KEPT:
            del self._cycles[0], self._times[0]
        k = bisect_right(self._times, (self._times[0] + arrived) / 2, hi=len(self._times) - 1)
        return max(arrived - self._line(k, cycle), 0.0)

    def _append(self, cycle: int, arrived: float) -> None:
        """Add a point on the right; corners that are not below the line to it are none any more."""
        while len(self._cycles) > 1 and self._times[-1] >= self._between(cycle, arrived):
            del self._cycles[-1], self._times[-1]
        self._cycles.append(cycle)
        self._times.append(arrived)

    def _between(self, cycle: int, arrived: float) -> float:
        """Return the time at the last corner on the line from the one before it to a point, s."""
        (before, last), time = self._cycles[-2:], self._times[-2]
        return time + (arrived - time) * (last - before) / (cycle - before)

    def _line(self, k: int, cycle: int) -> float:
        """Return the time at a cycle on the edge that ends at a corner, s."""
        (c0, c1), (t0, t1) = self._cycles[k - 1 : k + 1], self._times[k - 1 : k + 1]
        return t1 + (t1 - t0) / (c1 - c0) * (cycle - c1)
