"""Fitting the paper's force law to measured forces."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, NoEquilibrium
from stretch_bt.model.calibration.measurements import Measurements, forces
from stretch_bt.model.checks import MOST_SD
from stretch_bt.model.force.calibrated import MOST_SHALLOW, SHALLOW, CalibratedHertz, StretchState
from stretch_bt.model.force.force_model import MOST, STRETCH_OFF, Range
from stretch_bt.model.hertz import hertz_force
from stretch_bt.units import Estimate

__all__ = ["effective_modulus", "fit_calibrated_hertz", "moduli"]

Array = npt.NDArray[np.float64]

_LOG_SCALES = np.geomspace(1e-3, 0.2, 120)  # m
_DECAYS = np.geomspace(2e-3, 0.2, 80)  # m
_STATES, _DIAMETERS = 2, 3
_ROUNDING = 1e-9  # m
_TOUCHES = 5e-4  # m; lighter presses say more of the zero of depth and of the sensor than of the law
_CLOSE = 1e-6  # of the logarithm of the decay
_ROUNDS = 10
_LEAST_SQUARE = 1e-12
_FALL = 0.02  # least fall from the smallest to the largest diameter, as a part of the modulus


def effective_modulus(
    depth: npt.ArrayLike, force: npt.ArrayLike, radius: npt.ArrayLike, force_sd: npt.ArrayLike = 0.0
) -> Estimate:
    """Return E*, Pa, of presses (n,), m and N, with a sphere: least squares through no force at no depth to the formula of Hertz.

    Its variance is the larger of two: by the residuals, and by the standard deviations `force_sd` of the forces, N, (n,) or one.
    """
    unit, given = np.asarray(hertz_force("sphere", depth, 1.0, radius=radius)), np.asarray(force)
    square = float(unit @ unit)
    value = float(unit @ given / square)
    left = given - value * unit
    scatter = float(left @ left) / max(len(left) - 1, 1)
    # few presses may agree by chance, and one always agrees with itself
    stated = float(np.sum((unit * np.asarray(force_sd)) ** 2)) / square
    return Estimate(value, math.sqrt(max(scatter, stated, 1e-12) / square))


def moduli(given: Measurements) -> tuple[Array, Array, Array, Array]:
    """Return the effective modulus of each state (n,): diameter and stretch, m, modulus and its standard deviation, Pa.

    It is the least-squares fit through no force at no depth of all depths and trials to the formula of Hertz, as in the paper.
    """
    states = np.unique(np.column_stack([np.round(2 * given.radius, 9), given.stretch]), axis=0)
    rows = []
    for diameter, stretch in states:
        of = given.of_diameter(float(diameter)) & (given.stretch == stretch) & (given.depth > 0)
        if of.any():
            found = effective_modulus(given.depth[of], given.force[of], float(diameter) / 2, given.force_sd[of])
            rows.append((diameter, stretch, found.value, found.sd))
    d, x, e, sd = np.array(rows).T
    return d, x, e, sd


def fit_calibrated_hertz(given: Measurements, provenance: dict[str, Any] | None = None) -> CalibratedHertz:
    """Return the paper's model: at each stretch a negative exponential in diameter, across stretches a logarithm.

    The decay is one for all stretches, and so is the scale of the logarithm, as each stretch has few diameters; the rest is linear
    least squares. Standard deviations and correlations follow from the residuals of the moduli of all stretches together:
    one stretch of three diameters leaves next to no residual. The scale is the mean of its logarithm from 1 to 200 mm, each weighted
    by how well the states follow it; two states follow any. `relative_sd` is the rms residual of forces at depths of 5 mm and
    more without their noise, as a part of the model's force; at lesser depths the formula of Hertz has the further error
    `shallow_sd`, for which presses below 0.5 mm do not count.

    Raises
    ------
    IllConditioned
        Fewer than two stretches or three diameters, moduli that do not fall with diameter, or forces that are mostly noise.
    """
    given.check()
    diameter, stretch, modulus, sd = moduli(given)
    stretches = np.unique(stretch)
    if len(stretches) < _STATES:
        raise IllConditioned(
            "all presses are at one stretch, which does not determine how the modulus rises; measure two or more"
        )
    fewest = min(len(np.unique(diameter[stretch == x])) for x in stretches)
    if fewest < _DIAMETERS:
        raise IllConditioned(
            f"the paper's model needs hemispheres of {_DIAMETERS} diameters at each stretch, as its negative exponential has as many "
            f"parameters, and there {'are' if fewest > 1 else 'is'} {fewest}; measure more diameters, or use the membrane model"
        )
    law = _Law(diameter, stretch, modulus, 1 / np.maximum(sd, 1e-3 * modulus))
    scale, scale_sd = law.scale()
    states, rows = law.states()
    model = CalibratedHertz(
        states, scale, 0.0, _range(given), provenance or {}, log_scale_sd=scale_sd, correlation=rows
    )
    return _with_residual(model, given)


@dataclass(frozen=True)
class _Law:
    """Moduli, Pa, that fall with diameter as one negative exponential and rise with stretch as one logarithm; all (n,), m and 1/Pa."""

    diameter: Array
    stretch: Array
    modulus: Array
    weight: Array

    def states(self) -> tuple[tuple[StretchState, ...], tuple[tuple[float, ...], ...]]:
        """Return floors, amplitudes and the decay in which all stretches together agree best, and their correlation.

        Raises
        ------
        IllConditioned
            The moduli do not fall with diameter.
        """
        decay = self._decay()
        values, left = self._least(self._falling(decay))
        n = len(values) // 2
        covariance = self._covariance(decay, values[n:]) * _spread(left, len(self.stretch) - 2 * n - 1)
        sds = np.sqrt(np.diag(covariance))
        each = [np.unique(self.stretch), values[:n], sds[:n], values[n:], sds[n:-1]]
        columns = np.array([*each, np.full(n, decay), np.full(n, sds[-1])])
        states = [StretchState(*row) for row in columns.T.tolist()]
        order = [*range(2 * n), *[2 * n] * n]  # each state has the decay of all
        rows = (covariance / np.outer(sds, sds))[np.ix_(order, order)]
        np.fill_diagonal(rows, 1.0)
        return tuple(states), tuple(tuple(map(float, row)) for row in (rows + rows.T) / 2)

    def scale(self) -> tuple[float, float]:
        """Return the scale of the logarithm, m, and the standard deviation of its own logarithm."""
        lefts = np.array([self._least(self._rising(scale))[1] for scale in _LOG_SCALES])
        free = len(self.stretch) - 2 * len(np.unique(self.diameter)) - 1
        chances = np.exp(-(lefts - lefts.min()) / 2 / _spread(float(lefts.min()), free))
        chances /= chances.sum()
        logs = np.log(_LOG_SCALES)
        mean = float(chances @ logs)
        return math.exp(mean), math.sqrt(float(chances @ (logs - mean) ** 2))

    @cached_property
    def _of_state(self) -> Array:
        """(n, states) float, 1 where a modulus is of a stretch."""
        return np.asarray(self.stretch[:, None] == np.unique(self.stretch), float)

    def _falling(self, decay: float) -> Array:
        """Return (n, 2 states) float, what floors and amplitudes add to the moduli."""
        return np.hstack([self._of_state, np.exp(-self.diameter / decay)[:, None] * self._of_state])

    def _rising(self, scale: float) -> Array:
        """Return (n, 2 diameters) float, what p and q of each diameter add to the moduli."""
        of = np.asarray(self.diameter[:, None] == np.unique(self.diameter), float)
        return np.hstack([of, np.log1p(self.stretch / scale)[:, None] * of])

    def _least(self, design: Array) -> tuple[Array, float]:
        """Return the parameters with the least sum of squared weighted residuals, and the sum."""
        scaled, wanted = design * self.weight[:, None], self.modulus * self.weight
        found, *_ = np.linalg.lstsq(scaled, wanted)
        left = wanted - scaled @ found
        return np.asarray(found), float(left @ left)

    def _decay(self) -> float:
        from scipy.optimize import minimize_scalar

        def left(log: float) -> float:
            return self._least(self._falling(math.exp(log)))[1]

        logs = np.log(_DECAYS)
        best = int(np.argmin([left(log) for log in logs]))
        values = self._least(self._falling(_DECAYS[best]))[0]
        ends = np.exp(-np.array([self.diameter.min(), self.diameter.max()]) / _DECAYS[best])
        fall = float(np.mean(values[len(values) // 2 :])) * float(ends[0] - ends[1])
        if best in (0, len(_DECAYS) - 1) or fall < _FALL * float(self.modulus.mean()):
            raise IllConditioned(
                "the effective modulus does not fall with diameter as a negative exponential does, so that it has no decay; "
                "use the membrane model"
            )
        around = (logs[best - 1], logs[best + 1])
        return math.exp(minimize_scalar(left, bounds=around, method="bounded", options={"xatol": _CLOSE}).x)

    def _covariance(self, decay: float, amplitudes: Array) -> Array:
        """Return (2 states + 1, 2 states + 1) of floors, amplitudes and the decay, for weighted residuals of 1."""
        by_decay = self._falling(decay)[:, len(amplitudes) :] @ amplitudes * self.diameter / decay**2
        jacobian = np.column_stack([self._falling(decay), by_decay]) * self.weight[:, None]
        sizes = np.linalg.norm(jacobian, axis=0)
        inverse = np.linalg.inv((jacobian / sizes).T @ (jacobian / sizes))
        return np.asarray(inverse / np.outer(sizes, sizes))


def _spread(left: float, freedom: int) -> float:
    """Return the variance of weighted residuals, at least 1, as a few may agree by chance."""
    return max(left / max(freedom, 1), 1.0)


def _with_residual(model: CalibratedHertz, given: Measurements) -> CalibratedHertz:
    """Return the model with what it leaves of forces at depths from 5 mm, and more of it at lesser depths."""
    pressed = given.where(given.depth > 0)
    try:
        told = forces(model, pressed)
    except NoEquilibrium:  # no modulus above 0 at some of them
        told = np.zeros_like(pressed.force)
    size = np.maximum(told, 1e-3)
    off, noise = ((pressed.force - told) / size) ** 2, (pressed.force_sd / size) ** 2
    deep = pressed.depth >= SHALLOW - _ROUNDING
    told_of = deep if deep.any() else ~deep
    rms = math.sqrt(float(np.mean(off[told_of])))
    if rms > MOST_SD:
        raise IllConditioned(
            f"the paper's model leaves {rms:.3g} times the forces that it says itself, so it predicts none of them; check the unit and "
            f"the noise of the force sensor, and the zero of depth"
        )
    relative = _without_noise(off[told_of], noise[told_of], 2 * len(model.states) + 2)
    light = ~deep & (pressed.depth >= _TOUCHES)
    shallow = _shallow(pressed.depth[light], (off - noise)[light] - relative**2) if deep.any() else 0.0
    return replace(model, relative_sd=relative, shallow_sd=min(shallow, MOST_SHALLOW))


def _without_noise(off: Array, noise: Array, parameters: int) -> float:
    """Return the rms of the law's own error, from squared relative residuals (n,) and the variances of the noise in them (n,).

    A press counts by how well it tells the law's error from noise. One standard deviation of what is found is the least.
    """
    noise = noise * max(1 - parameters / len(off), 0.0)
    square = float(np.mean(off))
    for _ in range(_ROUNDS):
        weight = 1 / (noise + square + _LEAST_SQUARE) ** 2
        square = float(weight @ (off - noise) / weight.sum())
        square = max(square, math.sqrt(2 / float(weight.sum())))
    return math.sqrt(square)


def _range(given: Measurements) -> Range:
    """Return where the model holds: the measured range, its stretches widened by how far a gripper may stand from a command."""
    least, most = given.range.stretch
    return replace(given.range, stretch=(max(least - STRETCH_OFF, 0.0), min(most + STRETCH_OFF, MOST["stretch"])))


def _shallow(depth: Array, more: Array) -> float:
    """Return `shallow_sd` from depths below `SHALLOW` (n,), m, and how far their squared relative residuals exceed the deeper ones (n,)."""
    nearer = (1 - depth / SHALLOW) ** 2
    return math.sqrt(max(float(more.sum()), 0.0) / float((nearer**2).sum())) if len(depth) else 0.0
