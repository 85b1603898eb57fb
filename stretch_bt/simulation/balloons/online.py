"""The force of a cap by its solver, worked out where it is asked."""

from __future__ import annotations

import math

from stretch_bt.simulation.balloons.balance import CapState
from stretch_bt.simulation.balloons.cap import Cap

__all__ = ["SolvedCap"]

_KEPT = 256


class SolvedCap:
    """The law of a cap, N and N/m by a drop in m; each drop is solved once, from the nearest one that is known.

    Past `limit`, m, where the hand would reach the rim, it goes on as the power law that it follows there, so that a search for
    the equilibrium may step there; the object refuses to stand so.
    """

    def __init__(self, cap: Cap, limit: float) -> None:
        self._cap, self._limit = cap, limit
        self._known: dict[float, CapState] = {}

    def __call__(self, drop: float) -> tuple[float, float]:
        """Return force and slope.

        Raises
        ------
        NoEquilibrium
            The solver finds none.
        """
        if drop <= 0:
            return 0.0, 0.0
        state = self.state(min(drop, self._limit))
        if drop <= self._limit:
            return state.force, state.stiffness
        power = state.stiffness * self._limit / state.force
        force = state.force * math.pow(drop / self._limit, power)
        return force, power * force / drop

    def state(self, drop: float) -> CapState:
        """Return the equilibrium at a drop, m."""
        known = self._known
        if drop not in known:
            near = known[min(known, key=lambda d: abs(d - drop))] if known else None
            if len(known) >= _KEPT:
                known.clear()
            known[drop] = self._cap.press(drop, near)
        return known[drop]
