"""Thin walls that carry a load until they buckle, and then go on at a lower stiffness, or fall back first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.response import Law, Response

__all__ = ["BucklingResponse", "plate_buckling_force"]

POST = 0.4


def plate_buckling_force(bending_stiffness: float, width: float, count: int = 1) -> float:
    """Return the force at which `count` equal plates buckle together, N.

    N_cr = k pi^2 D / b^2 per width of a plate pressed along one direction, all edges simply supported, with k = 4 from a
    square one on (Timoshenko and Gere, Theory of Elastic Stability, section 9.2).

    Parameters
    ----------
    bending_stiffness
        D = E t^3 / (12 (1 - nu^2)) of the plate, N m.
    width
        Width of one plate, b, m.
    count
        Number of plates.
    """
    return count * 4 * math.pi**2 * bending_stiffness / width


@dataclass(frozen=True)
class BucklingResponse(Response):
    """Straight up to the `critical` force, N, at the first `stiffness`, N/m; beyond it at `post` of that.

    The edges of a buckled plate go on carrying: 0.41 of the first stiffness where they may move inwards, 0.5 where they stay
    straight (von Karman, Sechler and Donnell 1932; Koiter 1943), so `post` is 0.4. A curved wall snaps instead: its force
    falls by the part `fall` of the critical one while the drop grows by `over`, m, and rises from there. Walls pressed
    beyond that spring back along the same line, so it has no memory unless its force falls: then its force depends on the drop
    it comes from.

    Raises
    ------
    InvalidInput
        A stiffness, force or part is out of range.
    """

    stiffness: float
    critical: float
    post: float = POST
    fall: float = 0.0
    over: float = 0.0

    def __post_init__(self) -> None:
        if not (0 < self.stiffness < math.inf and 0 < self.critical < math.inf and 0 < self.post <= 1):
            raise InvalidInput(
                "walls need a finite stiffness and critical force above 0, and a part of it in (0, 1] after buckling"
            )
        if not (0 <= self.fall < 1 and (self.over > 0) == (self.fall > 0) and math.isfinite(self.over)):
            raise InvalidInput(
                "a force that falls by a part in (0, 1) needs a finite drop above 0 m over which it falls"
            )

    @property
    def memory(self) -> float | None:  # type: ignore[override]
        """None, unless the force falls."""
        return math.inf if self.fall else None

    @property
    def buckled(self) -> float:
        """Drop at which the walls buckle, m."""
        return self.critical / self.stiffness

    def start(self) -> float:
        """Return no drop."""
        return 0.0

    def force(self, drop: float) -> tuple[float, float]:
        """Return the force, N, and its slope, N/m, at a drop, m."""
        beyond = drop - self.buckled
        if beyond <= 0:
            return self.stiffness * drop, self.stiffness
        if beyond < self.over:
            slope = -self.fall * self.critical / self.over
            return self.critical + slope * beyond, slope
        slope = self.post * self.stiffness
        return (1 - self.fall) * self.critical + slope * (beyond - self.over), slope

    def law(self, state: Any, dt: float) -> Law:
        """Return its force, the same in every state."""
        return self.force

    def given(self, force: float) -> float:
        """Return the first drop, m, at which it carries a force, N, of at least 0."""
        if force <= self.critical:
            return force / self.stiffness
        after = force - (1 - self.fall) * self.critical
        return self.buckled + self.over + after / (self.post * self.stiffness)

    def kinks(self, state: Any) -> Sequence[float]:
        """Return where it buckles, and where its force rises again."""
        return (self.buckled, self.buckled + self.over) if self.fall else (self.buckled,)

    def drop(self, state: Any) -> float:
        """Return the drop at the begin of a step, m."""
        return 0.0 if state is None else float(state)

    def after(self, state: Any, drop: float, dt: float) -> float:
        """Return the drop."""
        return drop
