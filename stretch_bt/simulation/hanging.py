"""Objects that stick to the membrane: how a hand that rises pulls at one, and takes it along or tears itself free."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from stretch_bt.simulation.camera.skin import Grid
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.objects.response import Law
from stretch_bt.simulation.solve import find_root

__all__ = ["Grip", "Pulled", "between", "hung", "pulled_by"]

_FIRST = 2.5e-4  # m, the least way that is tried
_CLOSE = 1e-9
_STEP = 0.010  # m of stretch between solved laws: while the fingers move no two moments have one stretch


@dataclass(frozen=True, slots=True)
class Grip:
    """How an object sticks to the membrane, N: by a `pull` at most, against its `weight` and the `hold` of the table beside.

    `spot` is the body as which it holds on to the membrane, and `raised`, m, how far it hangs above where it stood.
    """

    pull: float
    weight: float
    hold: float
    spot: Indenter
    raised: float = 0.0

    @property
    def lifts(self) -> bool:
        """Whether it comes along with the hand."""
        return self.pull > self.weight + self.hold


class Pulled(NamedTuple):
    """The force that pulls the membrane down, N, how far it does, m, and how far the object is off the table, m."""

    force: float
    down: float
    raised: float


def pulled_by(law: Law, grip: Grip, above: float, close: float = _CLOSE) -> Pulled | None:
    """Return how an object pulls at a membrane whose free place would be `above`, m, its top on the table; None once it let go.

    On the table it bears up to the weaker of both bonds; an object that comes along hangs by its weight alone. `law` is the force
    that moves the membrane out of its plane, to either side, and ways are found to a part `close` of the trial.
    """
    held = min(grip.pull, grip.weight + grip.hold)
    if not grip.raised and _reach(law, held, above, close) >= above:
        return Pulled(law(above)[0], above, 0.0)
    if not grip.lifts:
        return None
    down = _reach(law, grip.weight, above, close)
    return Pulled(grip.weight if down < above else law(above)[0], down, above - down)


def between(stretch: float, solved: Callable[[float], Law]) -> Law:
    """Return the law at a stretch, m, in a straight line between those that are solved, a centimetre apart."""
    whole = math.floor(stretch / _STEP + 1e-9)
    part = max(stretch / _STEP - whole, 0.0)
    low = solved(whole * _STEP)
    if part < _CLOSE:
        return low
    high = solved((whole + 1) * _STEP)

    def law(way: float) -> tuple[float, float]:
        (force, slope), (more, steeper) = low(way), high(way)
        return (1 - part) * force + part * more, (1 - part) * slope + part * steeper

    return law


def _reach(law: Law, force: float, most: float, close: float) -> float:
    """Return how far a force moves the membrane, m; `most` where that takes no more force."""
    if force <= 0 or most <= 0:
        return min(0.0, most)
    way = min(_FIRST, most)
    while law(way)[0] < force:
        if way >= most:
            return most
        way = min(2 * way, most)

    def left(x: float) -> tuple[float, float]:
        found, slope = law(x)
        return force - found, -slope

    return find_root(left, 0.0, way, way / 2, "a membrane that is pulled down", close).x


def hung(free: Grid, pushed: Grid) -> Grid:
    """Return the membrane pulled down, as the mirror image, about how it hangs freely, of one that is pushed up as far.

    That is exact for a membrane without weight, whose two sides are alike; points (rows, columns, 3) are of the same places.
    """
    points = pushed.points.copy()
    points[..., 2] = 2 * free.points[..., 2] - points[..., 2]
    return Grid(np.ascontiguousarray(points))
