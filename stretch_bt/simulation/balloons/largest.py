"""The common part of responses that remember the largest drop so far."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass
from typing import Any

from stretch_bt.simulation.balloons.memory import longest_step
from stretch_bt.simulation.objects.response import Response

__all__ = ["LargestDrop", "RemembersLargest"]


@dataclass(frozen=True, slots=True)
class LargestDrop:
    """The largest drop so far, m, and the state of the response within."""

    largest: float
    inner: Any


class RemembersLargest(Response, ABC):
    """A response around another whose law depends on the largest drop so far."""

    def __init__(self, inner: Response) -> None:
        self.inner = inner
        self.memory = longest_step(inner, float("inf"))

    def start(self) -> LargestDrop:
        """Nothing has pushed."""
        return LargestDrop(0.0, self.inner.start())

    def kinks(self, state: LargestDrop) -> tuple[float, ...]:
        """Return where it was pressed to, m."""
        return (state.largest, *self.inner.kinks(state.inner))

    def after(self, state: LargestDrop, drop: float, dt: float) -> LargestDrop:
        """Return the state after a step."""
        return LargestDrop(max(state.largest, drop), self.inner.after(state.inner, drop, dt))

    def rest(self, state: LargestDrop, dt: float) -> float:
        """Return the rest of the response within, m."""
        return self.inner.rest(state.inner, dt)
