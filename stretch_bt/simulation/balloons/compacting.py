"""Grains that settle under a push and do not come back: stiffer unloading, and a set that stays."""

from __future__ import annotations

from stretch_bt.simulation.balloons.largest import LargestDrop, RemembersLargest
from stretch_bt.simulation.objects.response import Law, Response

__all__ = ["Compacting"]


class Compacting(RemembersLargest):
    """A response that unloads, and loads again up to its largest drop m, `ratio` times as stiff as it was loaded.

    F(d) = F1(m (d - s) / (m - s)) below m, with the set s = m (1 - 1 / ratio): the law of first loading F1 compressed along
    the drop, so that the force at m is the same. 1 - 1 / ratio of the work of loading is lost.
    """

    def __init__(self, inner: Response, ratio: float) -> None:
        super().__init__(inner)
        self.ratio = ratio

    def law(self, state: LargestDrop, dt: float) -> Law:
        """Return the force of the grains as they lie."""
        first, largest = self.inner.law(state.inner, dt), state.largest
        rest = self._set(largest)

        def force(drop: float) -> tuple[float, float]:
            if drop >= largest:
                return first(drop)
            if drop <= rest:
                return 0.0, 0.0
            value, slope = first(self.ratio * (drop - rest))
            return value, self.ratio * slope

        return force

    def rest(self, state: LargestDrop, dt: float) -> float:
        """Return the set, m."""
        return max(self._set(state.largest), self.inner.rest(state.inner, dt))

    def _set(self, largest: float) -> float:
        return largest * (1 - 1 / self.ratio)
