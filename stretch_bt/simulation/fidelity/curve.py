"""Force against depth between solved presses, so that a force that is only felt costs no solve of its own."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium

__all__ = ["Curve"]

Array = npt.NDArray[np.float64]

_STEP = 1e-3  # m between solved presses, finer where the press is shallow
_SHALLOW = (0.0625e-3, 0.125e-3, 0.25e-3, 0.5e-3)
_POWER = 1.5  # power of the travel in the force of the shallowest presses, where they do not determine it


class Curve:
    """The force of presses that differ in depth alone, by cubics through the four nearest solved ones.

    It interpolates the logarithm of the force over the logarithm of the membrane's travel past first touch, `lift`, m, above
    the plane: under a ball, an edge or a tip the force is nearly a power of it, each its own. Presses are solved when a depth near
    them is asked for. `python -m benchmarks.twin_curve` prints the error and the cost.
    """

    def __init__(self, solve: Callable[[float], Array], lift: float = 0.0) -> None:
        self._solve = solve
        self.lift = lift
        self._forces: dict[float, Array] = {}
        self._pieces: dict[int, _Cubic] = {}
        self._last: tuple[float, Array] | None = None
        self._too_deep = math.inf

    def __call__(self, depth: float) -> tuple[float, float]:
        """Return force along z, N, and slope, N/m, at a depth, m; both are 0 where nothing touches."""
        travel = depth + self.lift
        if travel <= 0:
            return 0.0, 0.0
        right = _index(travel)
        if right in self._pieces:
            return self._pieces[right](travel)
        knots = self._knots(travel)
        forces = [float(self._force(k)[2]) for k in reversed(knots)][::-1]  # each from the next deeper one
        if travel < knots[0]:
            rises = len(knots) > 1 and 0 < forces[0] < forces[1]
            power = math.log(forces[1] / forces[0]) / math.log(knots[1] / knots[0]) if rises else _POWER
            force = forces[0] * (travel / knots[0]) ** power
            return force, power * force / travel
        if min(forces) <= 0:  # some pass the object by
            right = next(i for i, k in enumerate(knots) if k >= travel) or 1
            return _lagrange(knots[right - 1 : right + 1], forces[right - 1 : right + 1], travel)
        piece = _Cubic(knots, forces)
        if right > 0 and knots[-1] in self._forces:  # else it ends at this very travel, where no press can be deeper
            self._pieces[right] = piece
        return piece(travel)

    def force(self, depth: float) -> Array:
        """Return the force (3,), N, at a depth, m."""
        upright = self(depth)[0]
        if upright <= 0:
            return np.zeros(3)
        travel = depth + self.lift
        knots = [k for k in self._knots(travel) if self._force(k)[2] > 0]
        places, at = [math.log(k) for k in knots], math.log(max(travel, knots[0]))
        leaning = [_lagrange(places, [self._force(k)[i] / self._force(k)[2] for k in knots], at)[0] for i in (0, 1)]
        return np.array([*leaning, 1.0]) * upright

    def _knots(self, travel: float) -> list[float]:
        """Return four travels around this one, or this one and shallower ones where the membrane cannot be pressed deeper."""
        right = _index(travel)
        first = max(right - 2, 0)
        knots = [k for k in map(_knot, range(first, first + 4)) if k < self._too_deep]
        while knots and knots[-1] > travel:
            try:
                self._force(knots[-1])
            except NoEquilibrium:
                self._too_deep = knots.pop()
            else:
                return knots
        return [k for k in map(_knot, range(max(first - 1, 0), right)) if k < self._too_deep] + [travel]

    def _force(self, travel: float) -> Array:
        if travel in self._forces:
            return self._forces[travel]
        if self._last is None or self._last[0] != travel:
            self._last = travel, self._solve(travel - self.lift)
        if travel == _knot(_index(travel)):
            self._forces[travel] = self._last[1]
        return self._last[1]


class _Cubic:
    """The cubic through the logarithms of travels and forces, all above 0, in Newton's form."""

    def __init__(self, travels: Sequence[float], forces: Sequence[float]) -> None:
        self.places = [math.log(k) for k in travels]
        self.steps = [math.log(f) for f in forces]
        for order in range(1, len(self.places)):
            for i in reversed(range(order, len(self.places))):
                apart = self.places[i] - self.places[i - order]
                self.steps[i] = (self.steps[i] - self.steps[i - 1]) / apart

    def __call__(self, travel: float) -> tuple[float, float]:
        """Return force, N, and slope, N/m."""
        at, level, power = math.log(travel), 0.0, 0.0
        for place, step in zip(reversed(self.places), reversed(self.steps), strict=True):
            power = level + (at - place) * power
            level = step + (at - place) * level
        force = math.exp(level)
        return force, power * force / travel


def _index(travel: float) -> int:
    """Return the number of the first solved press that is as deep."""
    return next((i for i, k in enumerate(_SHALLOW) if k >= travel), len(_SHALLOW) + math.ceil(travel / _STEP) - 1)


def _knot(index: int) -> float:
    return _SHALLOW[index] if index < len(_SHALLOW) else (index - len(_SHALLOW) + 1) * _STEP


def _lagrange(places: Sequence[float], values: Sequence[float], at: float) -> tuple[float, float]:
    """Return value and derivative of the polynomial through the points."""
    value, slope = 0.0, 0.0
    for i, (place, height) in enumerate(zip(places, values, strict=True)):
        others = [p for k, p in enumerate(places) if k != i]
        scale = height / math.prod(place - p for p in others)
        value += scale * math.prod(at - p for p in others)
        slope += scale * sum(
            math.prod(at - p for k, p in enumerate(others) if k != skip) for skip in range(len(others))
        )
    return value, slope
