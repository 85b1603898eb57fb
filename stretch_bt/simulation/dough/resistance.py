"""How a lump resists a press, as a smooth law of how deep it is pressed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.dough.lump import Lump
from stretch_bt.simulation.dough.material import Dough

__all__ = ["Resistance"]

_KNOTS = 16
_MOST = 0.75  # part of the distance from its underside to its centroid up to which its section is known
_NUDGE = 1e-6  # step for a slope, over the height
_HALVINGS = 60


class Resistance:
    """The force of a lump on a plate that is pressed down on it, beyond the `load`, N, under which it lies already.

    It rises with the depth, up to the height of the lump. The section under a plane comes from the volume below it, between
    depths that lie closer near the underside, and is made to rise: a field of radii is rough.
    """

    def __init__(self, lump: Lump, dough: Dough, load: float = 0.0) -> None:
        self.lump, self._dough = lump, dough.numbers()
        self.height = lump.height
        self._table = _sections(lump)
        self._before = 0.0
        #: how deep the load presses it, m, at most to half of its height
        self.sunk = 0.0 if load <= 0 else self._first(lambda deep: self._answer(deep, math.inf)[0] >= load)
        resting, self._before = self._answer(self.sunk, math.inf)
        # a face that does not spring back bears more than the load before it gives way; else the force begins at 0 exactly
        self._load = load if resting > (1 + 1e-6) * load else resting

    def force(self, drop: float, dt: float = math.inf) -> tuple[float, float]:
        """Return the force, N, and its derivative, N/m, at the end of a step of dt, s, to a drop below where it lies, m."""
        nudge = _NUDGE * self.height
        force, more = (self._answer(self.sunk + d, dt)[0] - self._load for d in (drop, drop + nudge))
        return max(force, 0.0), max(more - force, 0.0) / nudge

    def plastic(self, drop: float, dt: float = math.inf) -> float:
        """Return the part of its height, m, that is gone for good after a step of dt, s, to a drop, m."""
        return self._answer(self.sunk + drop, dt)[1]

    def _answer(self, deep: float, dt: float) -> tuple[float, float]:
        from stretch_bt.simulation.dough.law_kernel import answer

        table, volume = self._table, self.lump.volume
        found: tuple[float, float] = answer(table, volume, self.height, deep, self._before, dt, self._dough)
        return found

    def _first(self, reached: Callable[[float], bool]) -> float:
        low, high = 0.0, self.height / 2
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (low, middle) if reached(middle) else (middle, high)
        return high


def _sections(lump: Lump) -> npt.NDArray[np.float64]:
    """Return depths (k,), m, sections there, m^2, and their slopes, m, as a table (k, 3)."""
    from scipy.interpolate import PchipInterpolator

    under = lump.upward < -1e-3
    up, radii = lump.upward[under], lump.radii[under]
    low = lump.extent[0]
    edges = _MOST * low * np.linspace(0, 1, _KNOTS + 1) ** 1.5
    planes = (low - edges)[:, None] / -up
    below = np.maximum(radii**3 - planes**3, 0.0).sum(axis=1) * lump.directions.solid_angle / 3
    middles = (edges[1:] + edges[:-1]) / 2
    mean = np.maximum.accumulate(np.diff(below) / np.diff(edges))
    # to the underside in a straight line, up to the first mean: a point there, or a face
    first = min(max(mean[0] - (mean[1] - mean[0]) * middles[0] / (middles[1] - middles[0]), 0.0), mean[0])
    depths, sections = np.r_[0.0, middles], np.r_[first, mean]
    return np.ascontiguousarray(np.column_stack([depths, sections, PchipInterpolator(depths, sections)(depths, 1)]))
