"""Force against depth between solved presses, so that a force that is only felt costs no solve of its own."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium

__all__ = ["Curve"]

Array = npt.NDArray[np.float64]

_STEP = 1e-3  # m between solved presses, finer where the press is shallow
_SHALLOW = (0.0625e-3, 0.125e-3, 0.25e-3, 0.5e-3)
_POWER = 1.5  # the force over this power of the depth varies slowly


class Curve:
    """The force of presses that differ in depth alone, by cubics through the four nearest solved ones.

    What is interpolated is force / (depth + lift)^1.5, which varies slowly; `lift`, m, is how far above the plane the membrane
    already touches. Presses are solved when a depth near them is asked for. Against presses solved at the depth itself the force
    is within 0.1 % from 1 mm on (`benchmarks/twin_curve.py`).
    """

    def __init__(self, solve: Callable[[float], Array], lift: float = 0.0) -> None:
        self._solve = solve
        self.lift = lift
        self._values: dict[float, Array] = {}

    def __call__(self, depth: float) -> tuple[float, float]:
        """Return force along z, N, and slope, N/m, at a depth, m; both are 0 where nothing touches."""
        travel = depth + self.lift
        if travel <= 0:
            return 0.0, 0.0
        level, slope = self._level(travel)
        root = math.sqrt(travel)
        return float(level[2] * travel * root), float(slope[2] * travel * root + _POWER * level[2] * root)

    def force(self, depth: float) -> Array:
        """Return the force (3,), N, at a depth, m."""
        travel = depth + self.lift
        return np.zeros(3) if travel <= 0 else np.asarray(self._level(travel)[0] * travel**_POWER)

    def _level(self, travel: float) -> tuple[Array, Array]:
        """Return force / travel^1.5 (3,) and its slope."""
        knots = self._knots(travel)
        if travel < knots[0]:
            return self._value(knots[0]), np.zeros(3)
        return _lagrange(knots, [self._value(k) for k in knots], travel)

    def _knots(self, travel: float) -> list[float]:
        """Return four travels around this one, or this one and shallower ones where the membrane cannot be pressed deeper."""
        right = next((i for i, k in enumerate(_SHALLOW) if k >= travel), len(_SHALLOW) + math.ceil(travel / _STEP) - 1)
        first = max(right - 2, 0)
        knots = [_knot(i) for i in range(first, first + 4)]
        while knots[-1] > travel:
            try:
                self._value(knots[-1])
            except NoEquilibrium:
                knots.pop()
            else:
                return knots
        self._value(travel)
        return [_knot(i) for i in range(max(first - 1, 0), right)] + [travel]

    def _value(self, travel: float) -> Array:
        if travel not in self._values:
            self._values[travel] = self._solve(travel - self.lift) / travel**_POWER
        return self._values[travel]


def _knot(index: int) -> float:
    return _SHALLOW[index] if index < len(_SHALLOW) else (index - len(_SHALLOW) + 1) * _STEP


def _lagrange(places: list[float], values: list[Array], at: float) -> tuple[Array, Array]:
    """Return value and derivative of the polynomial through the points."""
    value, slope = np.zeros(3), np.zeros(3)
    for i, (place, height) in enumerate(zip(places, values, strict=True)):
        others = [p for k, p in enumerate(places) if k != i]
        scale = height / math.prod(place - p for p in others)
        value += scale * math.prod(at - p for p in others)
        slope += scale * sum(
            math.prod(at - p for k, p in enumerate(others) if k != skip) for skip in range(len(others))
        )
    return value, slope
