"""Grains that settle under a push and do not come back: stiffer unloading, and a set that stays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stretch_bt.simulation.balloons.memory import longest_step
from stretch_bt.simulation.objects.response import Law, Response

__all__ = ["Compacted", "Compacting"]


@dataclass(frozen=True, slots=True)
class Compacted:
    """The largest drop so far, m, and the state of what is compacted."""

    largest: float
    inner: Any


class Compacting(Response):
    """A response that unloads, and loads again up to its largest drop m, `ratio` times as stiff as it was loaded.

    F(d) = F1(m (d - s) / (m - s)) below m, with the set s = m (1 - 1 / ratio): the law of first loading F1 compressed along
    the drop, so that the force at m is the same. 1 - 1 / ratio of the work of loading is lost.
    """

    def __init__(self, inner: Response, ratio: float) -> None:
        self.inner, self.ratio = inner, ratio
        self.memory = longest_step(inner, float("inf"))

    def start(self) -> Compacted:
        """Nothing has pushed."""
        return Compacted(0.0, self.inner.start())

    def law(self, state: Compacted, dt: float) -> Law:
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

    def kinks(self, state: Compacted) -> tuple[float, ...]:
        """Return where it was pressed to, m."""
        return (state.largest, *self.inner.kinks(state.inner))

    def after(self, state: Compacted, drop: float, dt: float) -> Compacted:
        """Return the grains after a step."""
        return Compacted(max(state.largest, drop), self.inner.after(state.inner, drop, dt))

    def rest(self, state: Compacted, dt: float) -> float:
        """Return the set, m."""
        return max(self._set(state.largest), self.inner.rest(state.inner, dt))

    def _set(self, largest: float) -> float:
        return largest * (1 - 1 / self.ratio)
