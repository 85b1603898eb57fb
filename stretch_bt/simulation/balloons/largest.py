"""The common part of responses that remember the largest drop so far."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass
from typing import Any

from stretch_bt.simulation.balloons.memory import longest_step
from stretch_bt.simulation.objects.response import Response

__all__ = ["Pressed", "RemembersLargest"]


@dataclass(frozen=True, slots=True)
class Pressed:
    """The largest drop so far, m, and the state of the response within."""

    largest: float
    inner: Any


class RemembersLargest(Response, ABC):
    """A response around another whose law depends on the largest drop so far."""

    def __init__(self, inner: Response) -> None:
        self.inner = inner
        self.memory = longest_step(inner, float("inf"))

    def start(self) -> Pressed:
        """Nothing has pushed."""
        return Pressed(0.0, self.inner.start())

    def kinks(self, state: Pressed) -> tuple[float, ...]:
        """Return where it was pressed to, m."""
        return (state.largest, *self.inner.kinks(state.inner))

    def after(self, state: Pressed, drop: float, dt: float) -> Pressed:
        """Return the state after a step."""
        return Pressed(max(state.largest, drop), self.inner.after(state.inner, drop, dt))

    def rest(self, state: Pressed, dt: float) -> float:
        """Return the rest of the response within, m."""
        return self.inner.rest(state.inner, dt)
