"""Membrane and object in series: the hand's travel is shared between the two until their forces agree."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.solve import find_root

__all__ = ["Equilibrium", "couple"]

Law = Callable[[float], tuple[float, float]]


class Equilibrium(NamedTuple):
    """Depth of the membrane and drop of the object, m, their common force, N, and the evaluations it took."""

    depth: float
    drop: float
    force: float
    iterations: int


def couple(membrane: Law, compliance: float, travel: float) -> Equilibrium:
    """Return the equilibrium of the membrane and a linearly elastic object pressed together by `travel`.

    Solves membrane(depth) = (travel - depth) / compliance for the depth in [0, travel] by bracketed Newton; the residual
    is monotone, so there is one root. A staggered iteration would fail over half of the range of stiffness ratios.

    Parameters
    ----------
    membrane
        Returns force, N, and its derivative, N/m, at a depth, m; rising from 0 and convex.
    compliance
        Height that the object loses per force, m/N; 0 when rigid.
    travel
        How far the hand is past first contact, m.

    Raises
    ------
    NoEquilibrium
        No convergence within the budget.
    """
    if not (travel >= 0 and compliance >= 0):
        raise InvalidInput(f"travel and compliance must be at least 0, not {travel} m and {compliance} m/N")

    def residual(depth: float) -> tuple[float, float]:
        force, slope = membrane(depth)
        return travel - depth - compliance * force, -1 - compliance * slope

    if travel == 0:
        return Equilibrium(0.0, 0.0, 0.0, 0)
    start = _guess(membrane, compliance, travel)
    depth, iterations = find_root(residual, 0.0, travel, start, "membrane and object in series")
    force = membrane(depth)[0]
    return Equilibrium(depth, compliance * force, force, iterations)


def _guess(membrane: Law, compliance: float, travel: float) -> float:
    """Return a depth at or above the equilibrium, from which Newton approaches it from one side.

    It takes the membrane for the power law that it follows at full travel, and the object's drop for all of the travel.
    """
    force, slope = membrane(travel)
    if compliance * force <= travel:
        return travel
    power = slope * travel / force
    return travel * math.pow(travel / (compliance * force), 1 / power)
