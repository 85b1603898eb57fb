"""Force against depth between solved presses, so that a force that is only felt costs no solve of its own."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from stretch_bt.errors import NoEquilibrium

__all__ = ["Curve"]

_STEP = 1e-3  # m between solved presses, finer where the press is shallow
_SHALLOW = (0.0625e-3, 0.125e-3, 0.25e-3, 0.5e-3)
_POWER = 1.5  # the force over this power of the depth varies slowly


class Curve:
    """The force of presses that differ in depth alone, by cubics through the four nearest solved ones.

    What is interpolated is force / (depth + lift)^1.5, which varies slowly; `lift`, m, is how far above the plane the membrane
    already touches. Presses are solved when a depth near them is asked for. Against presses solved at the depth itself the force
    is within 0.1 % from 1 mm on (`benchmarks/twin_curve.py`).
    """

    def __init__(self, solve: Callable[[float], float], lift: float = 0.0) -> None:
        self._solve = solve
        self.lift = lift
        self._values: dict[float, float] = {}
        self._deepest = math.inf
        self._failure: NoEquilibrium | None = None

    def __call__(self, depth: float) -> tuple[float, float]:
        """Return force, N, and slope, N/m, at a depth, m; both are 0 where nothing touches."""
        travel = depth + self.lift
        if travel <= 0:
            return 0.0, 0.0
        knots = self._knots(travel)
        values = np.array([self._value(k) for k in knots])
        level, slope = _lagrange(np.array(knots), values, travel)
        if len(knots) == 1 or travel < knots[0]:
            level, slope = values[0], 0.0
        root = math.sqrt(travel)
        return float(level * travel * root), float(slope * travel * root + _POWER * level * root)

    def _knots(self, travel: float) -> list[float]:
        """Return up to four travels around this one, as deep as the membrane can be pressed."""
        if travel > self._deepest:
            assert self._failure is not None
            raise self._failure
        right = next((i for i, k in enumerate(_SHALLOW) if k >= travel), None)
        first = right - 2 if right is not None else len(_SHALLOW) + math.ceil(travel / _STEP) - 3
        chosen = [_knot(i) for i in range(max(first, 0), max(first, 0) + 4)]
        return self._reachable(chosen, travel)

    def _reachable(self, knots: list[float], travel: float) -> list[float]:
        """Return the knots with those that have no equilibrium replaced by shallower ones."""
        for k in knots:
            try:
                self._value(k)
            except NoEquilibrium as failure:
                if k <= travel + 1e-12 or not self._solvable(travel):
                    self._deepest, self._failure = min(self._deepest, travel), failure
                    raise
                index = _index(knots[0])
                known = [_knot(i) for i in range(max(index - 4, 0), index + 4) if _knot(i) < k]
                return sorted([*known[-3:], travel])
        return knots

    def _solvable(self, travel: float) -> bool:
        try:
            self._value(travel)
        except NoEquilibrium:
            return False
        return True

    def _value(self, travel: float) -> float:
        if travel not in self._values:
            self._values[travel] = self._solve(travel - self.lift) / travel**_POWER
        return self._values[travel]


def _knot(index: int) -> float:
    return _SHALLOW[index] if index < len(_SHALLOW) else (index - len(_SHALLOW) + 1) * _STEP


def _index(knot: float) -> int:
    return _SHALLOW.index(knot) if knot in _SHALLOW else len(_SHALLOW) + round(knot / _STEP) - 1


def _lagrange(places: np.ndarray, values: np.ndarray, at: float) -> tuple[float, float]:
    """Return value and derivative of the polynomial through the points."""
    value = slope = 0.0
    for i, (place, height) in enumerate(zip(places, values, strict=True)):
        others = np.delete(places, i)
        scale = height / float(np.prod(place - others))
        factors = at - others
        value += scale * float(np.prod(factors))
        slope += scale * sum(float(np.prod(np.delete(factors, j))) for j in range(len(others)))
    return value, slope
