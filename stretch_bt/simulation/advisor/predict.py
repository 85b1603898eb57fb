"""Difference of the twin's results from the results with every possible effect on, for each choice of effects."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.effects.base import Size

__all__ = ["SAME", "Predicted", "predicted", "predictions"]

SAME = 1 + 1e-9  # factor on a tolerance, for rounding


@dataclass(frozen=True, slots=True)
class Predicted:
    """The predicted difference of one result beside its tolerance, SI.

    `solver` is the 95th percentile of the error of the sheet's setting, None where none is known; `effects` the joint change by the
    effects left off, times the spread of their estimates; `value` the root of the sum of both squares, and `total` the plain sum of all.
    `left_off` names them, the largest first. The effects are infinite, and so is all with them, where no estimate of one of them holds.
    """

    observable: str
    tolerance: float
    value: float
    solver: float | None
    effects: float
    total: float
    left_off: tuple[str, ...]

    @property
    def ratio(self) -> float:
        """The prediction over the tolerance."""
        return self.value / self.tolerance

    @property
    def within(self) -> bool:
        """Whether it is known and within the tolerance."""
        return self.solver is not None and self.ratio <= SAME


def predictions(sizes: Sequence[Size | None], off: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """Return the joint change of one result by the effects left off, for each choice (n, effects) bool.

    Effects known to make it larger are added up, and so are effects known to make it smaller; the larger of both sums counts. It and
    the effects of unknown sign are independent, so that their squares add up.
    """
    value, way = (np.array([getattr(size, name) if size else 0.0 for size in sizes]) for name in ("value", "way"))
    up, down = (np.where(off & (way == sign), value, 0.0).sum(axis=1) for sign in (1, -1))
    unsigned = np.where(off & (way == 0), value**2, 0.0).sum(axis=1)
    found: npt.NDArray[np.float64] = np.sqrt(np.maximum(up, down) ** 2 + unsigned)
    return found


def predicted(
    tolerances: Mapping[str, float],
    off: Mapping[str, Mapping[str, Size]],
    solver: Mapping[str, float],
    spread: float = 1.0,
) -> dict[str, Predicted]:
    """Return the prediction of each result that has a tolerance, with some effects left off and the error of the solver.

    Estimates count times `spread`, since the effects that are off may be so many times larger.
    """
    found = {}
    for name, tolerance in tolerances.items():
        parts = {effect: sizes[name] for effect, sizes in off.items() if name in sizes and sizes[name].value > 0}
        every = np.ones((1, len(parts)), dtype=np.bool_)
        effects = spread * float(predictions(list(parts.values()), every)[0]) if parts else 0.0
        own = solver.get(name)
        total = (own or 0.0) + spread * sum(size.value for size in parts.values())
        largest = tuple(sorted(parts, key=lambda effect: -parts[effect].value))
        value = math.hypot(own or 0.0, effects)
        found[name] = Predicted(name, tolerance, value, own, effects, total, largest)
    return found
