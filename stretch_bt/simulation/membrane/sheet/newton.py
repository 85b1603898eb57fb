"""Newton's method for a sheet: banded Cholesky, Armijo on the true energy, factors used again, a cure when not positive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.sheet.problem import EXACT, GRADIENT, PROJECTED, Evaluation, Problem
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["Done", "Outcome", "Step", "Tangent", "minimise"]

_REUSES = 2
_REUSE_BELOW = 0.3
_REUSE_RATE = 0.4
_HALVINGS = 16
_FIRST_SHIFT = 1e-5
_SHRINK = 0.2


@dataclass(slots=True)
class Step:
    """An accepted step: its largest component, the energy it promised, the length taken, and where it led."""

    size: float
    promise: float
    length: float
    before: Evaluation
    after: Evaluation


Done = Callable[[Step], bool]


@dataclass(slots=True)
class Outcome:
    """Where a minimisation ended."""

    control: Array
    evaluation: Evaluation
    iterations: int
    factors: int


def minimise(problem: Problem, control: Array, done: Done, budget: int) -> Outcome:
    """Return a minimum of the energy near `control` (ny, nx, 3); the array is left as it is.

    Raises
    ------
    NoEquilibrium
        The budget of iterations is spent, or no step lowers the energy.
    """
    return _Newton(problem, control.copy()).run(done, budget)


class Tangent:
    """The factored Hessian at control points (ny, nx, 3); `positive` says whether it is so without a cure.

    It is good until the problem makes room for other Hessians.
    """

    def __init__(self, problem: Problem, control: Array) -> None:
        self._newton = _Newton(problem, control)
        band = problem.room()
        problem.evaluate(control, EXACT, band)
        self._newton.factorise(band)
        self.positive = self._newton.positive

    def solve(self, change: Array) -> Array:
        """Return the move of the unknowns (ny - 2, nx, 3) that changes the gradient by as much."""
        return self._newton.solve(change)


class _Newton:
    def __init__(self, problem: Problem, control: Array) -> None:
        from scipy.linalg.lapack import dpbtrf, dpbtrs

        self.problem, self.control = problem, control
        self._cholesky, self._substitute = dpbtrf, dpbtrs
        self.shift = 0.0
        self.factors = self.reuses = 0
        self.positive = True
        self.factor: Array | None = None

    def run(self, done: Done, budget: int) -> Outcome:
        band = self.problem.room()
        here = self.problem.evaluate(self.control, EXACT, band)
        if not np.isfinite(here.energy):
            raise NoEquilibrium("the start folds an element over")
        pending: Array | None = band
        last = np.inf
        for iteration in range(1, budget + 1):
            if pending is not None:
                self.factorise(pending)
                last = np.inf
            direction = -self.solve(here.gradient[1:-1])
            size = float(np.abs(direction).max())
            keep = self.reuses < _REUSES and size < _REUSE_BELOW and size < _REUSE_RATE * last
            step, pending = self._search(here, direction, size, keep)
            if step is None:
                if self.reuses == 0:
                    raise NoEquilibrium("no step along Newton's direction lowers the energy")
                pending = self.problem.room()
                here = self.problem.evaluate(self.control, EXACT, pending)
                continue
            self.reuses = self.reuses + 1 if keep else 0
            here, last = step.after, size
            if done(step):
                return Outcome(self.control, here, iteration, self.factors)
        raise NoEquilibrium(f"no equilibrium within {budget} iterations")

    def factorise(self, band: Array) -> None:
        """Factor the Hessian here; where it is not positive, project it, then shift it."""
        self.factors += 1
        self.reuses = 0
        if self.shift:
            band[:, 0] += self.shift
        self.factor, info = self._cholesky(band.T, lower=1, overwrite_ab=1)
        self.positive = info == 0 and not self.shift
        if info == 0:
            self.shift = self.shift * _SHRINK if self.shift * _SHRINK >= _FIRST_SHIFT else 0.0
            return
        while True:
            band = self.problem.room()
            self.problem.evaluate(self.control, PROJECTED, band)
            band[:, 0] += self.shift
            self.factor, info = self._cholesky(band.T, lower=1, overwrite_ab=1)
            if info == 0:
                return
            self.shift = max(10 * self.shift, _FIRST_SHIFT)
            if self.shift > 1e6:
                raise NoEquilibrium("the tangent cannot be made positive")

    def solve(self, change: Array) -> Array:
        solved, _ = self._substitute(self.factor, change.reshape(-1), lower=1)
        return np.asarray(solved).reshape(change.shape)

    def _search(self, here: Evaluation, direction: Array, size: float, keep: bool) -> tuple[Step | None, Array | None]:
        """Try the full step, then halves; the Hessian comes along unless the factor is kept."""
        promise = float(np.vdot(here.gradient[1:-1], direction))
        length = min(1.0, self.problem.largest_step / size) if size > 0 else 1.0
        slack = 1e-13 * (abs(here.energy) + 1.0) * 10
        start = self.control
        for _ in range(_HALVINGS):
            trial = start.copy()
            trial[1:-1] += length * direction
            band = None if keep else self.problem.room()
            there = self.problem.evaluate(trial, GRADIENT if keep else EXACT, band)
            if there.energy <= here.energy + 1e-4 * length * promise + slack:
                self.control = trial
                return Step(size * length, promise, length, here, there), band
            length /= 2
        return None, None
