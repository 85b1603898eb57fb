"""The membrane force model: what the solved sheet says, with the few numbers of a hand that a calibration finds."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model.force_model import ForceModel, Range, require_force
from stretch_bt.model.membrane_table import Axis, read_table
from stretch_bt.model.root import rising_root
from stretch_bt.units import KINDS, format_quantity

__all__ = ["BOUNDS", "PARAMETERS", "Hand", "MembraneModel"]

Array = npt.NDArray[np.float64]

_LENGTH = KINDS["Length"]
_STEP = 1e-4
_SOFTENED = 0.5  # of its stress, that the table's membrane has lost
_EVEN = 0.01  # m between stretches
_CLOSE = 1e-13


class Hand(NamedTuple):
    """What a calibration finds of a hand: Pa, m, m, and three numbers without a unit.

    `second_invariant` is the share of I2 in Mooney and Rivlin's energy, and `friction` that of the force which the table's
    coefficient of 0.5 adds. `softening` is the part of its stress that the membrane has lost where it was stretched much
    further before (Mullins).
    """

    shear_modulus: float
    thickness: float
    mount_prestretch: float
    second_invariant: float = 0.0
    friction: float = 0.0
    softening: float = 0.0

    @property
    def tension(self) -> float:
        """Shear modulus times thickness, N/m: what all forces are proportional to."""
        return self.shear_modulus * self.thickness

    def logarithms(self, stretches: Array, conditioned: float) -> Array:
        """Return (diameters, n, depths) float, the logarithm of the force over tension and unit, at stretches (n,), m.

        `conditioned` is the stretch, m, up to which the membrane was pressed before.
        """
        table = read_table()
        return table.logarithms(
            self.mount_prestretch + stretches,
            share=self.second_invariant,
            friction=self.friction,
            bending=(self.thickness / table.thickness) ** 2,
            weight=table.modulus / self.shear_modulus,
            softening=self.softening / _SOFTENED,
            softened=self.mount_prestretch + conditioned,
        )


PARAMETERS = Hand._fields
#: least and most of each parameter of a hand: what lies beyond is no such membrane
BOUNDS: dict[str, tuple[float, float]] = {
    "shear_modulus": (1e3, 1e7),
    "thickness": (2e-4, 0.02),
    "mount_prestretch": (0.0, 0.04),
    "second_invariant": (0.0, 0.6),
    "friction": (0.0, 2.0),
    "softening": (0.0, 0.5),
}


@dataclass(frozen=True)
class MembraneModel(ForceModel):
    """The force of a hemisphere in the middle of the membrane, from presses of the finite-strain sheet (`MembraneTable`).

    `covariance` (6, 6) is that of the parameters in the order of `Hand`; `relative_sd` is what the model leaves unexplained,
    as a part of the force, and `conditioned` the stretch, m, up to which the membrane was pressed before.
    """

    kind: ClassVar[str] = "membrane"
    hand: Hand
    covariance: tuple[tuple[float, ...], ...]
    relative_sd: float
    range: Range
    provenance: dict[str, Any] = field(default_factory=dict)
    conditioned: float = 0.08

    def __post_init__(self) -> None:
        values = [*self.hand, self.relative_sd, *(v for row in self.covariance for v in row)]
        if not all(isinstance(v, int | float) and math.isfinite(v) for v in values):
            raise InvalidInput(f"a membrane model needs finite numbers, got {self.hand}")
        if len(self.covariance) != len(PARAMETERS) or any(len(row) != len(PARAMETERS) for row in self.covariance):
            raise InvalidInput(f"a membrane model needs a covariance of {len(PARAMETERS)} by {len(PARAMETERS)}")
        if min(self.hand[:2]) <= 0 or self.hand.mount_prestretch < 0 or self.relative_sd < 0:
            raise InvalidInput("shear modulus and thickness must be above 0, pre-stretch and relative_sd at least 0")
        if not (
            isinstance(self.conditioned, int | float) and math.isfinite(self.conditioned) and self.conditioned >= 0
        ):
            raise InvalidInput(
                f"the stretch a membrane was conditioned at must be a length of at least 0 m, not {self.conditioned!r}"
            )

    def predict(self, radius: float, stretch: float, depth: float) -> tuple[float, float]:
        """Return the force, N, and its standard deviation."""
        self._check(radius, stretch, depth)
        if depth == 0:
            return 0.0, 0.0
        at, down = math.log(depth), self.grids.depth
        level, spread = _curves(self, radius, stretch)
        force = self._unit * math.exp(_along(down, level, at))
        return force, force * math.hypot(self.relative_sd, _along(down, spread, at))

    def depth_for(self, radius: float, stretch: float, force: float) -> float:
        """Return the depth, m, at which the force, N, is this one."""
        require_force(force)
        self.range.check(radius=radius, stretch=stretch)
        if force == 0:
            return 0.0
        deepest, wanted, down = self.deepest(radius, stretch), math.log(force / self._unit), self.grids.depth
        level, _ = _curves(self, radius, stretch)
        end = math.log(deepest)
        most = _along(down, level, end)
        if wanted > most + 1e-12:
            raise NoEquilibrium(
                f"{force:.3g} N is not reached at stretch {format_quantity(stretch, _LENGTH)}: at the deepest, "
                f"{format_quantity(deepest, _LENGTH)}, the force is {self._unit * math.exp(most):.3g} N"
            )
        slope = _slope(down, level, down.places[0])
        start = down.places[0] + (wanted - _along(down, level, down.places[0])) / slope
        if start <= down.places[0]:
            return math.exp(start)
        return math.exp(rising_root(lambda a: _along(down, level, a) - wanted, down.places[0], end))

    def stretch_for(self, radius: float, depth: float, force: float) -> float:
        """Return the stretch, m, at which the force, N, is this one."""
        require_force(force)
        self.range.check(radius=radius, depth=depth)
        if depth == 0 or force == 0:
            raise NoEquilibrium("at depth 0 there is no force at any stretch, and past it there is one at each")
        grids = self.grids
        held = np.tensordot(grids.diameter.weights(math.log(2 * radius)), grids.level, 1)
        level = held @ grids.depth.weights(math.log(depth))
        rising = _rising_from(level, math.log(force / self._unit))
        if rising is None:
            weakest, strongest = (self._unit * math.exp(v) for v in (level.min(), level.max()))
            raise NoEquilibrium(
                f"no stretch gives {force:.4g} N at a depth of {format_quantity(depth, _LENGTH)}; the calibrated "
                f"stretches give {weakest:.4g} to {strongest:.4g} N"
            )

        def off(stretch: float) -> float:
            return float(grids.stretch.weights(stretch) @ level) - math.log(force / self._unit)

        found = rising_root(off, *grids.stretch.places[rising : rising + 2])
        self._check(radius, found, depth)
        return found

    def deepest(self, radius: float, stretch: float) -> float:
        """Return the deepest press, m, that the range allows and the membrane can bear."""
        return min(self.range.depth[1], read_table().reach(2 * radius, self.hand.mount_prestretch + stretch))

    @property
    def _unit(self) -> float:
        return self.hand.tension * read_table().gauge / 100

    def _check(self, radius: float, stretch: float, depth: float) -> None:
        self.range.check(radius=radius, stretch=stretch, depth=depth)
        deepest = self.deepest(radius, stretch)
        if depth > deepest:
            raise InvalidInput(
                f"depth {format_quantity(depth, _LENGTH)} is past {format_quantity(deepest, _LENGTH)}, beyond which the "
                f"membrane would wrap around so small a sphere"
            )

    def to_json(self) -> dict[str, Any]:
        """Return the parameters, SI, each with its standard deviation."""
        sds = np.sqrt(np.diag(np.array(self.covariance)))
        return {
            "provenance": self.provenance,
            "units": "SI: Pa, m; second_invariant, friction and softening without a unit; relative_sd is a part of the force",
            "range": asdict(self.range),
            "hand": self.hand._asdict(),
            "sd": dict(zip(PARAMETERS, sds.tolist(), strict=True)),
            "covariance": [list(row) for row in self.covariance],
            "relative_sd": self.relative_sd,
            "conditioned": self.conditioned,
        }

    @classmethod
    def from_json(cls, fields: dict[str, Any]) -> MembraneModel:
        """Return the model with these parameters."""
        limits = Range(**{name: (float(low), float(high)) for name, (low, high) in fields["range"].items()})
        covariance = tuple(tuple(row) for row in fields["covariance"])
        return cls(
            Hand(**fields["hand"]),
            covariance,
            fields["relative_sd"],
            limits,
            fields["provenance"],
            fields["conditioned"],
        )

    @cached_property
    def grids(self) -> _Grids:
        """Splines over the hand's own forces."""
        return _Grids.of(self)

    @cached_property
    def _kept(self) -> dict[str, Any]:
        return {}


@dataclass(frozen=True)
class _Grids:
    """Splines over a hand's own forces: (diameters, stretches, depths) of their logarithm, and of its standard deviation."""

    diameter: Axis
    stretch: Axis
    depth: Axis
    level: Array
    spread: Array

    @classmethod
    def of(cls, model: MembraneModel) -> _Grids:
        diameter, _, depth = read_table().axes
        stretches = _stretches(model)
        level = model.hand.logarithms(stretches, model.conditioned)
        rates = np.array([_rate(model, name, stretches, level) for name in PARAMETERS])
        variance = np.einsum("aijk,ab,bijk->ijk", rates, np.array(model.covariance), rates)
        return cls(diameter, Axis(stretches), depth, level, np.sqrt(np.maximum(variance, 0.0)))


def _stretches(model: MembraneModel) -> Array:
    """Return the stretches of the splines, m: close to each other where softening ends."""
    most = model.range.stretch[1]
    even = np.linspace(0.0, most, max(round(most / _EVEN), 4) + 1)
    near = model.conditioned + read_table().pasts
    far = even[np.min(np.abs(even[:, None] - near), axis=1) > _EVEN / 4]
    return np.unique(np.concatenate([far, near[(near > 0) & (near < most)], [0.0, most]]).round(9))


def _rate(model: MembraneModel, name: str, stretches: Array, level: Array) -> Array:
    """Return how the logarithm of the force, N, changes with one parameter."""
    hand = model.hand
    step = _STEP * max(getattr(hand, name), 0.1)
    moved = hand._replace(**{name: getattr(hand, name) + step})
    off = moved.logarithms(stretches, model.conditioned) - level
    rate: Array = (off + math.log(moved.tension / hand.tension)) / step
    return rate


def _curves(model: MembraneModel, radius: float, stretch: float) -> tuple[list[Any], list[Any]]:
    """Return the pieces over depth of the logarithm and of its deviation; the last pair is kept."""
    kept, key = model._kept, (radius, stretch)
    if kept.get("key") != key:
        grids = model.grids
        across = grids.diameter.weights(math.log(2 * radius))
        along = grids.stretch.weights(stretch)
        pair = []
        for values in (grids.level, grids.spread):
            line = along @ (across @ values.reshape(len(across), -1)).reshape(values.shape[1:])
            pair.append([*(grids.depth.pieces @ line).T.tolist(), line.tolist()])
        kept["key"], kept["pair"] = key, tuple(pair)
    found: tuple[list[Any], list[Any]] = kept["pair"]
    return found


def _along(axis: Axis, pieces: list[Any], at: float) -> float:
    """Return the value of a curve at the logarithm of a depth; before the first place and past the last it is a straight line."""
    places = axis.places
    k = min(max(bisect_right(places, at) - 1, 0), len(places) - 2)
    if at < places[0] or at > places[-1]:
        end = 0 if at < places[0] else -1
        value: float = pieces[-1][end] + _slope(axis, pieces, places[end]) * (at - places[end])
        return value
    a, b, c, d = pieces[k]
    t = at - places[k]
    found: float = ((a * t + b) * t + c) * t + d
    return found


def _slope(axis: Axis, pieces: list[Any], at: float) -> float:
    k = min(max(bisect_right(axis.places, at) - 1, 0), len(axis.places) - 2)
    a, b, c, _ = pieces[k]
    t = at - axis.places[k]
    found: float = (3 * a * t + 2 * b) * t + c
    return found


def _rising_from(level: Array, wanted: float) -> int | None:
    """Return the last of the stretches from which the logarithm of the force rises past a value, None where it does not.

    A membrane that hangs is met earlier the slacker it is, so that at a slight depth the force falls with stretch first.
    """
    passes = np.flatnonzero((level[:-1] <= wanted + _CLOSE) & (level[1:] >= wanted - _CLOSE))
    return int(passes[-1]) if passes.size else None
