"""How an object answers a push: the force at its top as a function of how far the top has given way."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

__all__ = ["Law", "LinearResponse", "Response"]

#: force, N, and its derivative, N/m, at a drop of the top, m
Law = Callable[[float], tuple[float, float]]


class Response(ABC):
    """A force law, with memory where it has one; states are values that never change.

    `memory` is None where the force depends on the drop alone, infinite where it depends on the path of drops but not on time,
    and else the longest time step, s, that the law can be asked to take.
    """

    memory: float | None = None

    def start(self) -> Any:
        """Return the state before the first push."""
        return None

    @abstractmethod
    def law(self, state: Any, dt: float) -> Law:
        """Return the force at the end of a step of `dt`, s, that begins in this state, as a function of the drop reached.

        Steps are implicit, so that no step is too long for stability. The force is 0 at drops at which nothing touches.
        """

    def kinks(self, state: Any) -> Sequence[float]:
        """Return the drops, m, at which the slope of the force jumps; between them the force is smooth and monotone.

        Where the force falls with the drop, the drop reached is the first equilibrium on the way from `drop(state)`.
        """
        return ()

    def drop(self, state: Any) -> float:
        """Return the drop at the begin of a step, m; of use to a law whose force may fall."""
        return 0.0

    def after(self, state: Any, drop: float, dt: float) -> Any:
        """Return the state after a step to this drop, m."""
        return state

    def rest(self, state: Any, dt: float) -> float:
        """Return the drop, m, up to which the top stays down by itself after `dt`, s, without a force."""
        return 0.0


@dataclass(frozen=True)
class LinearResponse(Response):
    """A spring of a stiffness, N/m; an infinite one gives no answer and belongs to a rigid object."""

    stiffness: float

    def __post_init__(self) -> None:
        assert math.isfinite(self.stiffness)

    def law(self, state: Any, dt: float) -> Law:
        """Return the force of the spring."""
        return lambda drop: (self.stiffness * drop, self.stiffness)
