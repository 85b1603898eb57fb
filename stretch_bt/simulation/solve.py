"""One root of a monotone function, safely."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from stretch_bt.errors import NoEquilibrium

__all__ = ["Root", "find_root"]

BUDGET = 60


class Root(NamedTuple):
    """Where the function vanishes, and how many evaluations that took."""

    x: float
    iterations: int


def find_root(
    function: Callable[[float], tuple[float, float]],
    low: float,
    high: float,
    start: float,
    what: str,
    rtol: float = 1e-12,
) -> Root:
    """Return the root of a falling function between low and high by Newton steps held inside the bracket.

    `function` returns value and derivative. Newton converges from `start` where the function is convex; a step that
    leaves the bracket is replaced by bisection, so that the bracket shrinks at every evaluation.

    Raises
    ------
    NoEquilibrium
        The step does not fall below `rtol` times the bracket within the budget; `what` names the case.
    """
    width = high - low
    x = start
    for iteration in range(1, BUDGET + 1):
        value, slope = function(x)
        low, high = (x, high) if value > 0 else (low, x)
        step = -value / slope if slope < 0 else float("inf")
        following = x + step
        if value == 0 or abs(step) <= rtol * width:
            return Root(min(max(following, low), high) if value else x, iteration)
        x = following if low < following < high else (low + high) / 2
    raise NoEquilibrium(f"{what}: no convergence within {BUDGET} evaluations")
