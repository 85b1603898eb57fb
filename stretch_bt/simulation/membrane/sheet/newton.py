"""Newton's method for a sheet: banded Cholesky, Armijo on the true energy, factors used again, a cure when not positive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stretch_bt.break_off import go_on
from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.sheet.problem import EXACT, GRADIENT, PROJECTED, Evaluation, Problem
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["Done", "Minimum", "Newton", "NewtonStep"]

_REUSES = 2
_REUSE_BELOW = 0.3
_REUSE_RATE = 0.4
_HALVINGS = 16
_FIRST_SHIFT = 1e-5
_SHRINK = 0.2
_BALANCED = 1e-3  # part of the force that may be left where rounding is in the way of more


@dataclass(slots=True)
class NewtonStep:
    """An accepted step: its largest component, the energy it promised, and where it led."""

    size: float
    promise: float
    before: Evaluation
    after: Evaluation


Done = Callable[[NewtonStep], bool]


@dataclass(slots=True)
class Minimum:
    """Where a minimisation ended."""

    control: Array
    evaluation: Evaluation


class Newton:
    """A minimisation of a problem's energy from control points (ny, nx, 3), which are left as they are.

    It may be run again after the problem has changed a little: it goes on from where it was, with the factor it has.
    """

    def __init__(self, problem: Problem, control: Array) -> None:
        from scipy.linalg.lapack import dpbtrf, dpbtrs

        self.problem, self.control = problem, control.copy()
        self._cholesky, self._substitute = dpbtrf, dpbtrs
        self.shift = 0.0
        self.iterations = self.factors = self.reuses = 0
        self.positive = True
        self.fresh = False  # whether the factor is of the present place
        self._bands = problem.bands()
        self._held: int | None = None  # which band holds the factor; the other takes the next Hessian

    def run(self, done: Done, budget: int) -> Minimum:
        """Return a minimum.

        Raises
        ------
        NoEquilibrium
            The budget of iterations is spent, or no step lowers the energy.
        """
        pending = self._room() if self._held is None else None
        here = self.problem.evaluate(self.control, EXACT if self._held is None else GRADIENT, pending)
        if not np.isfinite(here.energy):
            raise NoEquilibrium("the start folds an element over")
        self.reuses, last = 0, np.inf
        for _ in range(budget):
            go_on()
            self.iterations += 1
            if pending is not None:
                self._factor(pending)
                last = np.inf
            direction = -self.solve(here.gradient[1:-1])
            size = float(np.abs(direction).max())
            keep = self.reuses < _REUSES and size < _REUSE_BELOW and size < _REUSE_RATE * last
            step, pending = self._search(here, direction, size, keep)
            if step is None:
                if self.reuses == 0 and self.fresh:
                    if _rounded(here, direction):
                        return Minimum(self.control, here)
                    raise NoEquilibrium(_stuck(here, direction))
                pending = self._room()
                here = self.problem.evaluate(self.control, EXACT, pending)
                continue
            self.reuses = self.reuses + 1 if keep else 0
            self.fresh = False
            here, last = step.after, size
            if done(step):
                return Minimum(self.control, here)
        raise NoEquilibrium(f"no equilibrium within {budget} iterations")

    def _room(self) -> Array:
        """Return the band that holds no factor, zeroed."""
        band = self._bands[0 if self._held is None else 1 - self._held]
        band.fill(0.0)
        return band

    def _factor(self, band: Array) -> None:
        """Factor the Hessian here; where it is not positive, project it, then shift it."""
        self.factors += 1
        self.reuses, self.fresh = 0, True
        self._held = 0 if self._held is None else 1 - self._held
        if self.shift:
            band[:, 0] += self.shift
        factored = self._cholesky(band.T, lower=1, overwrite_ab=1)[1] == 0
        self.positive = factored and not self.shift
        if factored:
            self.shift = self.shift * _SHRINK if self.shift * _SHRINK >= _FIRST_SHIFT else 0.0
            return
        while True:
            band.fill(0.0)
            self.problem.evaluate(self.control, PROJECTED, band)
            band[:, 0] += self.shift
            if self._cholesky(band.T, lower=1, overwrite_ab=1)[1] == 0:
                return
            self.shift = max(10 * self.shift, _FIRST_SHIFT)
            if self.shift > 1e6:
                raise NoEquilibrium("the tangent cannot be made positive")

    def refresh(self) -> None:
        """Factor the Hessian of the present place; `positive` then says whether it is so without a cure."""
        band = self._room()
        self.problem.evaluate(self.control, EXACT, band)
        self._factor(band)

    def solve(self, change: Array) -> Array:
        """Return the move of the unknowns (ny - 2, nx, 3) that changes the gradient by as much, by the factor at hand."""
        assert self._held is not None
        solved, _ = self._substitute(self._bands[self._held].T, change.reshape(-1), lower=1)
        return np.asarray(solved).reshape(change.shape)

    def _search(
        self, here: Evaluation, direction: Array, size: float, keep: bool
    ) -> tuple[NewtonStep | None, Array | None]:
        """Try the full step, then halves; the Hessian comes along unless the factor is kept."""
        promise = float(np.vdot(here.gradient[1:-1], direction))
        length = min(1.0, self.problem.largest_step / size) if size > 0 else 1.0
        noise = _noise(here.energy)
        start = self.control
        for _ in range(_HALVINGS):
            trial = start.copy()
            trial[1:-1] += length * direction
            band = None if keep else self._room()
            there = self.problem.evaluate(trial, GRADIENT if keep else EXACT, band)
            rise = there.energy - here.energy - 1e-4 * length * promise
            # an energy that changes by no more than its rounding says nothing, so the slope decides
            if rise < -noise or (rise <= noise and np.vdot(there.gradient[1:-1], direction) <= -0.5 * promise):
                self.control = trial
                return NewtonStep(size * length, promise, here, there), band
            length /= 2
        return None, None


def _noise(energy: float) -> float:
    """Return the rounding error of an energy of the sheet."""
    return 1e-12 * (abs(energy) + 1.0)


def _rounded(here: Evaluation, direction: Array) -> bool:
    """Return whether only rounding is left of the energy to gain, with the forces in balance."""
    left, force = here.gradient[1:-1].sum(axis=(0, 1)), float(np.linalg.norm(here.force))
    gain = -float(np.vdot(here.gradient[1:-1], direction))
    return bool(gain < _noise(here.energy) and np.linalg.norm(left) <= _BALANCED * force)


def _stuck(here: Evaluation, direction: Array) -> str:
    """Return why no step along a direction lowers the energy."""
    if -float(np.vdot(here.gradient[1:-1], direction)) < _noise(here.energy):
        return (
            "the load is too small to stand out of the rounding of the sheet's energy: press deeper or stretch further"
        )
    return "no step along Newton's direction lowers the energy"
