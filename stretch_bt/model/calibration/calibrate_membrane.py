"""Fitting the membrane force model to measured forces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.model.calibration.conditioning import CONDITIONED, Conditioning
from stretch_bt.model.calibration.depth_zero import DEPTH_ZERO, DepthZero
from stretch_bt.model.calibration.measurements import Measurements, forces
from stretch_bt.model.force.force_model import Range
from stretch_bt.model.force.membrane import MembraneModel
from stretch_bt.model.force.membrane_hand import BOUNDS, PARAMETERS, MembraneHand
from stretch_bt.model.force.membrane_table import read_table
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS

__all__ = ["ROBOT_SD", "at_an_end", "fit_membrane", "within_table"]

Array = npt.NDArray[np.float64]

ROBOT_SD = 5e-5  # m; standard deviation of where the arm stops
OFFSET_SD, COMMON_SD = (
    5e-5,
    2.5e-4,
)  # m; standard deviation of the depth's zero, for each mounted indenter, and for all by one camera
_MODEL = 0.01  # error of the model, as a part of a force, that the fit assumes before it is known
_LEAST_MODEL, _MOST_MODEL = 0.005, 0.3
_OUTLIER = 55.0  # times the median square: five standard deviations
_TOLD = 2e-3  # m; lighter presses say more of the zero of depth than of the model
_RISE = 1.3  # power of depth with which a force rises, about
_AT_END = 1e-3  # of a logarithm
_SETTLED = 1e-6  # of the deviation of a prior
_EXACT = 1e-9  # m
_ALONE = 0.02  # of a force, where there is nothing to leave out

# mean and standard deviation of the fitted parameters: logarithms of the first two
_PRIOR: dict[str, tuple[float, float]] = {
    "shear_modulus": (math.log(70e3), 1.0),
    "thickness": (math.log(0.002), 0.2),
    "mount_prestretch": (0.012, 0.010),
    "second_invariant": (0.1, 0.15),
    "friction": (0.65, 0.5),
    "softening": (0.08, 0.06),
}
_LOGARITHMS = PARAMETERS[:2]
_BOUNDS = {n: tuple(map(math.log, ends)) if n in _LOGARITHMS else ends for n, ends in BOUNDS.items()}
_SOFTENING = PARAMETERS.index("softening")
_UNSOFTENED = (0.0, math.hypot(*_PRIOR["softening"]))  # prior where it is not measured: 0, with its usual rms


def fit_membrane(
    given: Measurements, provenance: dict[str, Any] | None = None, *, judged: bool = True
) -> MembraneModel:
    """Return the membrane model that fits measured forces, with the covariance of its parameters.

    Shear modulus, thickness, mount pre-stretch, the share of the second invariant, friction, softening, and the zero of depth of all and of each
    indenter are found by robust least squares, each with a prior from such hands: the sheet's physics decides what the
    measurements do not. `relative_sd` is the rms error of forces on a diameter that the fit did not see,
    between others, at depths of 2 mm and more; where it is not to be `judged`, which takes a fit for each diameter, the usual
    error of such models. Presses past the table's range are left out, and the provenance says which.

    Raises
    ------
    IllConditioned
        There are too few presses within the table's range, or the force does not grow with depth.
    """
    given, notes = within_table(given)
    given.check()
    conditioned = given.conditioned or Conditioning(given.range.stretch[1], given.range.depth[1])
    found = _Fit.of(given, conditioned)
    relative = max(_left_out(given, conditioned), _LEAST_MODEL) if judged else _ALONE
    if relative > _MOST_MODEL or found.at_an_end:
        left = (
            "has no shear modulus or thickness for these forces"
            if found.at_an_end
            else f"leaves {100 * relative:.0f} % of them"
        )
        raise IllConditioned(
            f"these are not the forces of such a membrane: the model {left}; check the unit and the zero of the force sensor, and "
            f"the zero of depth"
        )
    said = {**_said(given, conditioned), DEPTH_ZERO: found.zero.to_json()}
    return found.model(relative, _range(given), {**(provenance or {}), **said, **notes})


def within_table(given: Measurements) -> tuple[Measurements, dict[str, list[str]]]:
    """Return the presses within the table of the sheet, and by the key `left_out` notes on the presses left out, if any.

    Raises
    ------
    IllConditioned
        Nothing is left.
    """
    table = read_table()
    least, most = float(table.diameters[0]), float(table.diameters[-1])
    far = float(table.spans[-1]) - _PRIOR["mount_prestretch"][0]
    sizes = (given.radius * 2 >= least - _EXACT) & (given.radius * 2 <= most + _EXACT)
    notes = [
        f"diameter {_mm(d)}, outside of {_mm(least)} to {_mm(most)}"
        for d in given.diameters
        if not sizes[given.of_diameter(d)].any()
    ]
    near, shallow = given.stretch <= far, given.depth <= float(table.depths[-1])
    notes += _presses("stretches", given.stretch[sizes & ~near], far)
    notes += _presses("depths", given.depth[sizes & near & ~shallow], float(table.depths[-1]))
    kept = sizes & near & shallow
    if not kept.any():
        raise IllConditioned(
            f"the membrane model covers none of the presses: left out are {'; '.join(notes)}; measure within, or use the paper's model"
        )
    return given.where(kept), {"left_out": notes} if notes else {}


def _presses(name: str, values: Array, most: float) -> list[str]:
    return [f"{len(values)} presses at {name} to {_mm(values.max())}, past {_mm(most)}"] if len(values) else []


def _mm(length: float) -> str:
    return format_quantity(float(length), KINDS["Length"])


def _said(given: Measurements, conditioned: Conditioning) -> dict[str, Any]:
    """Return the provenance's entry on the conditioning, with a note where something was assumed."""
    if given.conditioned is None:
        note = "not said by what was measured; taken as the largest stretch and depth in it"
    elif not conditioned.softens:
        note = "not conditioned: softening is held at 0, and its deviation is that of membranes that are"
    else:
        return {CONDITIONED: conditioned.to_json()}
    return {CONDITIONED: {**conditioned.to_json(), "note": note}}


def _range(given: Measurements) -> Range:
    """Return where the model holds: the table's sizes and depths, and from no stretch to the largest measured, or 80 mm."""
    table, measured = read_table(), given.range
    radii = float(table.diameters[0]) / 2, float(table.diameters[-1]) / 2
    return Range(radii, (0.0, max(measured.stretch[1], 0.08)), (0.0, float(table.depths[-1])))


def _left_out(given: Measurements, conditioned: Conditioning) -> float:
    """Return the rms relative error of forces at diameters left out of the fit in turn: each between others, or each of two.

    Depths count from the zero that the fit found, the variance of noise is subtracted, and outliers are left out. Where there is
    one diameter that was pressed, or no press is deep enough, it is the usual error of such models.
    """
    given = given.where(given.depth > 0)
    if len(given.diameters) < 2 or not (given.depth >= _TOLD).any():
        return _ALONE
    errors = []
    for diameter in given.diameters[1:-1] or given.diameters:
        mask = given.of_diameter(diameter)
        fit = _Fit.of(given.where(~mask), conditioned)
        model, left = fit.model(0.0, _range(given), {}), given.where(mask & (given.depth >= _TOLD))
        told = forces(model, fit.zero.applied(left))
        moved = math.hypot(ROBOT_SD, OFFSET_SD) * _RISE * left.force / left.depth
        errors.append(((told - left.force) ** 2 - left.force_sd**2 - moved**2) / np.maximum(told, 1e-3) ** 2)
    squares = np.concatenate(errors)
    if not squares.size:  # the deep presses are of the outermost diameters alone
        return _ALONE
    kept = squares[np.abs(squares) <= _OUTLIER * max(float(np.median(np.abs(squares))), 1e-8)]
    return math.sqrt(max(float(np.mean(kept)), 0.0))


@dataclass(frozen=True)
class _Fit:
    """The hand's parameters as they are fitted, the first two as logarithms, and their covariance."""

    values: Array
    covariance: Array
    conditioned: float
    zero: DepthZero
    measured: Range

    @classmethod
    def of(cls, given: Measurements, conditioned: Conditioning) -> _Fit:
        from scipy.optimize import least_squares

        problem = _Problem(given.where(given.depth > 0), conditioned)
        low, high = (np.array([_BOUNDS[n][k] for n in PARAMETERS] + problem.offsets(s)) for k, s in ((0, -20), (1, 20)))
        start = np.array([problem.prior[n][0] for n in PARAMETERS] + problem.offsets(0))
        done = least_squares(
            problem.residuals, start, bounds=(low, high), loss="soft_l1", f_scale=3.0, x_scale=problem.scale
        )
        if not done.success:
            raise IllConditioned(f"the membrane model does not fit these forces: {done.message}")
        jac = np.asarray(done.jac)
        covariance = np.linalg.inv(jac.T @ jac)
        n = len(PARAMETERS)
        spread = max(1.0, float(np.median(np.abs(done.fun[: len(problem)])) / 0.6745)) ** 2
        values = _settled(done.x[:n])
        if not conditioned.softens:
            values[_SOFTENING] = 0.0
        zero = problem.zero(done.x[n:], math.sqrt(covariance[n, n] * spread))
        return cls(values, covariance[:n, :n] * spread, problem.conditioned, zero, given.range)

    @property
    def at_an_end(self) -> bool:
        """Whether shear modulus or thickness stands at an end of its bounds."""
        ends = [_BOUNDS[name] for name in PARAMETERS[:2]]
        return any(min(v - low, high - v) < _AT_END for v, (low, high) in zip(self.values, ends, strict=False))

    def model(self, relative: float, limits: Range, provenance: dict[str, Any]) -> MembraneModel:
        """Return the model; logarithms become values."""
        scale = np.array([math.exp(self.values[0]), math.exp(self.values[1])] + [1.0] * (len(PARAMETERS) - 2))
        covariance = self.covariance * np.outer(scale, scale)
        rows = tuple(tuple(float(v) for v in row) for row in covariance)
        return MembraneModel(_hand(self.values), rows, relative, limits, provenance, self.conditioned, self.measured)


class _Problem:
    """Residuals of forces over their standard deviations, and of parameters over their priors' standard deviations."""

    def __init__(self, given: Measurements, conditioned: Conditioning) -> None:
        self.table = read_table()
        self.softens = conditioned.softens
        self.conditioned = conditioned.stretch if self.softens else given.range.stretch[1]
        self.prior = _PRIOR if self.softens else {**_PRIOR, "softening": _UNSOFTENED}
        self.given = given
        self.indenters = given.diameters
        self.indenter = np.array([int(np.argmin([abs(2 * r - d) for d in self.indenters])) for r in given.radius])
        states = np.column_stack([self.indenter, given.stretch])
        self.states, self.state = np.unique(states, axis=0, return_inverse=True)
        self.stretches, self.stretch = np.unique(self.states[:, 1], return_inverse=True)
        across, _, self.down = self.table.axes
        self.across = across.many(np.log(np.array(self.indenters)))[self.states[:, 0].astype(int)]
        rise = _RISE * given.force / np.maximum(given.depth, 5e-4)
        self.sd = np.sqrt(given.force_sd**2 + (ROBOT_SD * rise) ** 2 + (_MODEL * given.force) ** 2 + 1e-12)

    def __len__(self) -> int:
        return len(self.given)

    @property
    def scale(self) -> Array:
        """The size of a step in each parameter."""
        return np.array([self.prior[n][1] for n in PARAMETERS] + self.offsets(1))

    def offsets(self, sds: float) -> list[float]:
        """Return the offset common to all depths, and one for each indenter, at so many standard deviations, m."""
        return [COMMON_SD * sds] + [OFFSET_SD * sds] * len(self.indenters)

    def zero(self, offsets: Array, common_sd: float) -> DepthZero:
        """Return the zero of depth that offsets say, m: of all presses, with its standard deviation, then of each indenter."""
        each = zip(self.indenters, map(float, offsets[1:]), strict=True)
        return DepthZero(float(offsets[0]), common_sd, tuple(each))

    def residuals(self, values: Array) -> Array:
        """Return (n + parameters,) float."""
        hand, n = _hand(values), len(PARAMETERS)
        if not self.softens:
            hand = hand._replace(softening=0.0)
        common, offsets = values[n], values[n + 1 :]
        told = self.forces(hand, np.maximum(self.given.depth + common + offsets[self.indenter], 1e-6))
        held = [(values[k] - self.prior[name][0]) / self.prior[name][1] for k, name in enumerate(PARAMETERS)]
        return np.concatenate([(told - self.given.force) / self.sd, held, [common / COMMON_SD], offsets / OFFSET_SD])

    def forces(self, hand: MembraneHand, depth: Array) -> Array:
        """Return (n,) float, N."""
        level = hand.logarithms(self.stretches, self.conditioned)[:, self.stretch]
        lines = np.einsum("sd,dsk->sk", self.across, level)
        at = self.down.many(np.log(depth))
        unit = hand.tension * self.table.gauge / 100
        found: Array = unit * np.exp(np.einsum("nk,nk->n", at, lines[self.state]))
        return found


def at_an_end(name: str, value: float) -> bool:
    """Return whether a parameter stands at an end of its bounds, so that the measurements may want it further."""
    return value in BOUNDS[name]


def _settled(values: Array) -> Array:
    """Return values where one that stands at an end of its bounds, but for rounding, is set to that end."""
    for k, name in enumerate(PARAMETERS):
        for end in _BOUNDS[name]:
            if abs(values[k] - end) < _SETTLED * _PRIOR[name][1]:
                values[k] = end
    return values


def _hand(values: Array) -> MembraneHand:
    return MembraneHand(math.exp(values[0]), math.exp(values[1]), *(float(v) for v in values[2 : len(PARAMETERS)]))
