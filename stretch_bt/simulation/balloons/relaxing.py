"""A gel beside an elastic body: it resists a fast push and relaxes with time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from stretch_bt.simulation.balloons.memory import check_step, longest_step
from stretch_bt.simulation.objects.response import Law, Response
from stretch_bt.simulation.solve import find_root

__all__ = ["Relaxed", "Relaxing"]

#: s, the longest step: far below the times of a press, and below a tenth of the relaxation
_LONGEST = 0.05
_EXACT = 1e-12


@dataclass(frozen=True, slots=True)
class Relaxed:
    """Force of the branch, N, the force that it follows, N, and the drop, m, at the last step, and the state of the rest."""

    branch: float
    followed: float
    drop: float
    inner: Any


class Relaxing(Response):
    """A response with a Maxwell branch beside it: q' = g(d)' - q / time, F = F1(d) + q.

    That is the contact of a viscoelastic ball (Lee and Radok, J. Appl. Mech. 27, 1960) where g is the law of Hertz for the
    part of the modulus that relaxes. The branch is integrated exactly for a g that moves evenly over the step, implicitly in the
    drop. Lee and Radok's solution is for a contact that grows; here it serves one that shrinks as well.
    """

    def __init__(self, inner: Response, branch: Law, time: float) -> None:
        self.inner, self.branch, self.time = inner, branch, time
        self.memory = longest_step(inner, min(_LONGEST, time / 10))

    def start(self) -> Relaxed:
        """Return the state at rest."""
        return Relaxed(0.0, 0.0, 0.0, self.inner.start())

    def law(self, state: Relaxed, dt: float) -> Law:
        """Return the force at the end of a step; it only pushes."""
        raw = self._raw(state, dt)

        def force(drop: float) -> tuple[float, float]:
            value, slope = raw(drop)
            return (value, slope) if value > 0 else (0.0, 0.0)

        return force

    def kinks(self, state: Relaxed) -> tuple[float, ...]:
        """Return the inner's."""
        return tuple(self.inner.kinks(state.inner))

    def after(self, state: Relaxed, drop: float, dt: float) -> Relaxed:
        """Return the gel after a step; where the hand has left it behind, it comes back by itself."""
        reached = max(drop, self.rest(state, dt))
        kept, taken = self._factors(dt)
        followed = self.branch(reached)[0]
        pulled = kept * state.branch + taken * (followed - state.followed)
        return Relaxed(pulled, followed, reached, self.inner.after(state.inner, reached, dt))

    def rest(self, state: Relaxed, dt: float) -> float:
        """Return the drop, m, at which body and branch hold each other after a step without a push."""
        raw = self._raw(state, dt)
        if raw(0.0)[0] >= 0:
            return 0.0
        if raw(state.drop)[0] <= 0:
            return state.drop

        def falling(drop: float) -> tuple[float, float]:
            value, slope = raw(drop)
            return -value, -slope

        root = find_root(falling, 0.0, state.drop, state.drop, "a gel that comes back", _EXACT).x
        return max(root - 2 * _EXACT * state.drop, 0.0)  # on the side without a force

    def _factors(self, dt: float) -> tuple[float, float]:
        """Return the share of the branch left after a step, and the share that it takes of an even move during it."""
        check_step(dt)
        part = dt / self.time
        return math.exp(-part), -math.expm1(-part) / part if part > 0 else 1.0

    def _raw(self, state: Relaxed, dt: float) -> Law:
        """Return the force, below 0 where the branch would pull."""
        kept, taken = self._factors(dt)
        # the branch never has more than the force that it follows
        offset = min(kept * state.branch - taken * state.followed, 0.0)
        inner = self.inner.law(state.inner, dt)

        def force(drop: float) -> tuple[float, float]:
            (value, slope), (g, by) = inner(drop), self.branch(drop)
            return value + offset + taken * g, slope + taken * by

        return force
