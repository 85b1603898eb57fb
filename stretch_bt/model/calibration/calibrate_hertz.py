"""Fitting the paper's force law to measured forces."""

from __future__ import annotations

import math
from dataclasses import replace
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

_LOG_SCALES = np.geomspace(1e-3, 0.2, 60)  # m
_DECAYS = np.geomspace(2e-3, 0.2, 80)  # m
_STATES, _DIAMETERS = 2, 3
_ROUNDING = 1e-9  # m
_TOUCHES = 5e-4  # m; lighter presses say more of the zero of depth and of the sensor than of the law
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

    The decay is one for all stretches, and so is the scale of the logarithm, as each stretch has few diameters; both are the best of
    a grid, and the rest linear least squares. Standard deviations follow from the residuals of the moduli of all stretches together:
    one stretch of three diameters leaves next to no residual. `relative_sd` is the rms residual of forces at depths of 5 mm and
    more, as a part of the model's force; at lesser depths the formula of Hertz has the further error `shallow_sd`, for which presses
    below 0.5 mm do not count.

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
    decay, decay_sd = _decay(diameter, stretch, modulus, sd)
    by_stretch = {float(x): _of(x, stretch, diameter, modulus, sd) for x in stretches}
    left = sum(_line(decay, *arrays)[2] for arrays in by_stretch.values())
    spread = max(left / max(_freedom(stretch), 1), 1.0)  # as a few may agree by chance
    states = tuple(_state(x, decay, decay_sd, spread, *arrays) for x, arrays in by_stretch.items())
    return _scaled(given, states, provenance or {})


def _decay(diameter: Array, stretch: Array, modulus: Array, sd: Array) -> tuple[float, float]:
    """Return the decay in which all stretches together agree best, and its standard deviation, m."""
    costs = np.array(
        [sum(_line(d, *_of(x, stretch, diameter, modulus, sd))[2] for x in np.unique(stretch)) for d in _DECAYS]
    )
    best = int(np.argmin(costs))
    ends = np.exp(-np.array([diameter.min(), diameter.max()]) / _DECAYS[best])
    lines = [_line(_DECAYS[best], *_of(x, stretch, diameter, modulus, sd))[0] for x in np.unique(stretch)]
    fall = float(np.mean([line[1] for line in lines])) * float(ends[0] - ends[1])
    if best in (0, len(_DECAYS) - 1) or fall < _FALL * float(modulus.mean()):
        raise IllConditioned(
            "the effective modulus does not fall with diameter as a negative exponential does, so that it has no decay; "
            "use the membrane model"
        )
    level = costs[best] + max(costs[best] / max(_freedom(stretch), 1), 1.0)
    near = _DECAYS[costs <= level]
    return float(_DECAYS[best]), float(max(near.max() - near.min(), _DECAYS[best + 1] - _DECAYS[best - 1]) / 2)


def _freedom(stretch: Array) -> int:
    """Return by how many there are more moduli (n,) than parameters: two for each stretch, and the decay."""
    return len(stretch) - 2 * len(np.unique(stretch)) - 1


def _of(x: float, stretch: Array, *arrays: Array) -> list[Array]:
    return [a[stretch == x] for a in arrays]


def _line(decay: float, diameter: Array, modulus: Array, sd: Array) -> tuple[Array, Array, float]:
    """Return floor and amplitude (2,), their covariance for weighted residuals of 1, and the sum of squared residuals, for one stretch."""
    design = np.column_stack([np.ones_like(diameter), np.exp(-diameter / decay)])
    weight = 1 / np.maximum(sd, 1e-3 * modulus)
    found, *_ = np.linalg.lstsq(design * weight[:, None], modulus * weight)
    left = (modulus - design @ found) * weight
    scaled = design * weight[:, None]
    covariance = np.asarray(np.linalg.pinv(scaled.T @ scaled), float)
    return np.asarray(found), covariance, float(left @ left)


def _state(
    x: float, decay: float, decay_sd: float, spread: float, diameter: Array, modulus: Array, sd: Array
) -> StretchState:
    (floor, amplitude), covariance, _ = _line(decay, diameter, modulus, sd)
    floor_sd, amplitude_sd = (float(v) for v in np.sqrt(np.diag(covariance) * spread))
    return StretchState(x, float(floor), floor_sd, float(amplitude), amplitude_sd, decay, decay_sd)


def _scaled(given: Measurements, states: tuple[StretchState, ...], provenance: dict[str, Any]) -> CalibratedHertz:
    """Return the model at the scale of the logarithm with the least squared error."""
    made = [CalibratedHertz(states, float(scale), 0.0, _range(given), provenance) for scale in _LOG_SCALES]
    lefts = [_left(model, states, given) for model in made]
    best = made[int(np.argmin(lefts))]
    pressed = given.where(given.depth > 0)
    try:
        told = forces(best, pressed)
    except NoEquilibrium:  # no modulus above 0 at some of them
        told = np.zeros_like(pressed.force)
    off = ((pressed.force - told) / np.maximum(told, 1e-3)) ** 2
    deep = pressed.depth >= SHALLOW - _ROUNDING
    relative = math.sqrt(float(np.mean(off[deep] if deep.any() else off)))
    if relative > MOST_SD:
        raise IllConditioned(
            f"the paper's model leaves {relative:.3g} times the forces that it says itself, so it predicts none of them; check the unit and "
            f"the noise of the force sensor, and the zero of depth"
        )
    light = ~deep & (pressed.depth >= _TOUCHES)
    shallow = _shallow(pressed.depth[light], off[light] - relative**2) if deep.any() else 0.0
    return replace(best, relative_sd=relative, shallow_sd=min(shallow, MOST_SHALLOW))


def _range(given: Measurements) -> Range:
    """Return where the model holds: the measured range, its stretches widened by how far a gripper may stand from a command."""
    least, most = given.range.stretch
    return replace(given.range, stretch=(max(least - STRETCH_OFF, 0.0), min(most + STRETCH_OFF, MOST["stretch"])))


def _shallow(depth: Array, more: Array) -> float:
    """Return `shallow_sd` from depths below `SHALLOW` (n,), m, and how far their squared relative residuals exceed the deeper ones (n,)."""
    nearer = (1 - depth / SHALLOW) ** 2
    return math.sqrt(max(float(more.sum()), 0.0) / float((nearer**2).sum())) if len(depth) else 0.0


def _left(model: CalibratedHertz, states: tuple[StretchState, ...], given: Measurements) -> float:
    """Return the squared error of the logarithm at the states' own moduli."""
    pairs = [(model.fitted_modulus(d / 2, s.stretch)[0], s.modulus(d)[0]) for d in given.diameters for s in states]
    return sum((a - b) ** 2 for a, b in pairs)
