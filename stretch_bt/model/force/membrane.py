"""The membrane force model: forces of the solved sheet, with the few parameters of a hand that a calibration finds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_numbers
from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model.checks import MOST_SD, require_covariance, require_within
from stretch_bt.model.force.force_grids import ForceGrids, along, moved, slope
from stretch_bt.model.force.force_model import DEPTH_OFF, MOST, STRETCH_OFF, ForceModel, Range, require_force
from stretch_bt.model.force.membrane_hand import BOUNDS, PARAMETERS, MembraneHand
from stretch_bt.model.force.membrane_table import read_table
from stretch_bt.model.root import rising_root
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS, Estimate

__all__ = ["PARAMETERS", "MembraneHand", "MembraneModel"]

Array = npt.NDArray[np.float64]

_LENGTH = KINDS["Length"]
_CLOSE = 1e-13
_SAME = 1e-6  # m
_TENSE = 4e-3  # m of stretch, its mounts' included, from which a sheet hangs as a strip does, within 3 %
_HANG_OFF = 0.05  # relative error of a sag, from the strip's formula and the density: an assumption
# relative errors of a force, for each factor e in diameter and in depth, and for each m of stretch past the measured range: an
# assumption, on top of the covariance, for effects that no sheet of the table has
_BEYOND_SIZE, _BEYOND_STRETCH, _BEYOND_DEPTH = 0.01, 0.5, 0.01
# relative error of a force for each m of span below the table's: 2 mm below it a flat sheet has half of the force at 10 mm of depth
_BEYOND_SLACK = 300.0


@dataclass(frozen=True)
class MembraneModel(ForceModel):
    """The force of a hemisphere in the middle of the membrane, from presses of the finite-strain sheet (`MembraneTable`).

    `covariance` (6, 6) has the parameters in the order of `MembraneHand`; `relative_sd` is the residual of the model, as a part of the
    force, and `conditioned` the stretch, m, up to which the membrane was pressed before. Within `range`, but beyond the `measured`
    range, the deviation grows with the distance from it.
    """

    kind: ClassVar[str] = "membrane"
    hand: MembraneHand
    covariance: tuple[tuple[float, ...], ...]
    relative_sd: float
    range: Range
    provenance: dict[str, Any] = field(default_factory=dict)
    conditioned: float = 0.08
    measured: Range | None = None

    def __post_init__(self) -> None:
        for name, (low, high) in BOUNDS.items():
            require_within(f"hand.{name}", getattr(self.hand, name), low * (1 - _CLOSE), high * (1 + _CLOSE))
        require_within("relative_sd", self.relative_sd, 0.0, MOST_SD)
        require_within("conditioned", self.conditioned, 0.0, MOST["stretch"])
        require_covariance("covariance", self.covariance, len(PARAMETERS))
        self._check_range()

    def _check_range(self) -> None:
        """Raise InvalidInput where the range, or a radius that was measured, lies past the table's."""
        table = read_table()
        radii = float(table.diameters[0]) / 2, float(table.diameters[-1]) / 2
        ends = {"radius": radii, "stretch": (0.0, float(table.spans[-1])), "depth": (0.0, float(table.depths[-1]))}
        for name, (low, high) in ends.items():
            for end in getattr(self.range, name):
                require_within(f"range.{name}", end, low, high)
        if not self.range.stretch[1] > 0:
            raise InvalidInput("range.stretch: its upper end is above 0 m")
        for end in self.measured.radius if self.measured else ():
            require_within("measured.radius", end, radii[0] - _SAME, radii[1] + _SAME)

    def predict(self, radius: float, stretch: float, depth: float) -> tuple[float, float]:
        """Return the force, N, and its standard deviation."""
        self._check(radius, stretch, depth)
        if depth == 0:
            return 0.0, 0.0
        at, down = math.log(depth), self.grids.depth
        level, spread = _curves(self, radius, stretch)
        force = self._unit * math.exp(along(down, level, at))
        return force, force * math.hypot(
            self.relative_sd,
            along(down, spread, at),
            *self._beyond(radius, stretch, depth),
            *self._past_spans(stretch),
        )

    def depth_for(self, radius: float, stretch: float, force: float) -> float:
        """Return the depth, m, at which the force, N, is this one."""
        require_force(force)
        self.range.check(radius=radius, stretch=stretch)
        if force == 0:
            return 0.0
        deepest, wanted, down = self.deepest(radius, stretch), math.log(force / self._unit), self.grids.depth
        level, _ = _curves(self, radius, stretch)
        end = math.log(deepest)
        most = along(down, level, end)
        if wanted > most + 1e-12:
            raise NoEquilibrium(
                f"{force:.3g} N is not reached at stretch {format_quantity(stretch, _LENGTH)}: at the deepest, "
                f"{format_quantity(deepest, _LENGTH)}, the force is {self._unit * math.exp(most):.3g} N"
            )
        rate = slope(down, level, down.places[0])
        start = down.places[0] + (wanted - along(down, level, down.places[0])) / rate
        if start <= down.places[0]:
            return math.exp(start)
        return math.exp(rising_root(lambda a: along(down, level, a) - wanted, down.places[0], end))

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
        check_numbers("in m", radius=radius, stretch=stretch)
        return min(self.range.depth[1], read_table().reach(2 * radius, self.hand.mount_prestretch + stretch))

    @property
    def prestretch(self) -> Estimate:
        """By how much the mounts stretch the membrane at stretch 0, m."""
        place = PARAMETERS.index("mount_prestretch")
        return Estimate(self.hand.mount_prestretch, math.sqrt(self.covariance[place][place]))

    def hang(self, stretch: float) -> Estimate | None:
        """Return the sag of the free membrane in its middle, m, at a stretch, m; its sd includes the parameters' covariance.

        None for a membrane that is all but slack, which does not hang as a strip does.
        """
        self.range.check(stretch=stretch)
        if self.hand.mount_prestretch + stretch < _TENSE:
            return None
        told = self.hand.hang(stretch, self.conditioned)
        others = (moved(self.hand, name) for name in PARAMETERS)
        slopes = np.array([(hand.hang(stretch, self.conditioned) - told) / step for hand, step in others])
        own = float(slopes @ np.array(self.covariance) @ slopes)
        return Estimate(told, math.sqrt(max(own, 0.0) + (_HANG_OFF * told) ** 2))

    def in_range(self, radius: float, stretch: float, depth: float) -> bool:
        """Return whether forces were measured around there, and the table has them; the model may answer beyond."""
        return super().in_range(radius, stretch, depth) and not self._past_spans(stretch)

    def _past_spans(self, stretch: float) -> tuple[float, ...]:
        """Return the relative error that a force has because prestretch and stretch together lie past the table's spans."""
        low, high = self._spanned
        if low <= stretch <= high:
            return ()
        return (_BEYOND_SLACK * (low - stretch) if stretch < low else _BEYOND_STRETCH * (stretch - high),)

    def _beyond(self, radius: float, stretch: float, depth: float) -> tuple[float, ...]:
        """Return the relative errors that a force has because radius, stretch and depth lie past the measured range."""
        if self._seen is None:
            return ()
        low, high, slack, tense, deep = self._seen
        if low <= radius <= high and slack <= stretch <= tense and depth <= deep:
            return ()
        assert self.measured is not None
        radii, stretches, depths = self.measured.radius, self.measured.stretch, self.measured.depth
        size = max(math.log(radii[0] / radius), math.log(radius / radii[1]), 0.0)
        out = max(stretches[0] - stretch, stretch - stretches[1], 0.0)
        deeper = math.log(max(depth / depths[1], 1.0)) if depths[1] > 0 else 1.0
        return _BEYOND_SIZE * size, _BEYOND_STRETCH * out, _BEYOND_DEPTH * deeper

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
            "range": self.range.to_json(),
            "hand": self.hand._asdict(),
            "sd": dict(zip(PARAMETERS, sds.tolist(), strict=True)),
            "covariance": [list(row) for row in self.covariance],
            "relative_sd": self.relative_sd,
            "conditioned": self.conditioned,
            "measured": self.measured.to_json() if self.measured else None,
        }

    @classmethod
    def from_json(cls, fields: dict[str, Any]) -> MembraneModel:
        """Return the model with these parameters."""
        limits, measured = Range.from_json(fields["range"]), fields.get("measured")
        covariance = tuple(tuple(row) for row in fields["covariance"])
        return cls(
            MembraneHand(**fields["hand"]),
            covariance,
            fields["relative_sd"],
            limits,
            fields["provenance"],
            fields["conditioned"],
            None if measured is None else Range.from_json(measured, "measured"),
        )

    @cached_property
    def _seen(self) -> tuple[float, float, float, float, float] | None:
        """Bounds of radius, stretch and depth within which nothing is added to the deviation, as `Range.holds` has them."""
        if self.measured is None:
            return None
        (low, high), (slack, tense), (_, deep) = self.measured.radius, self.measured.stretch, self.measured.depth
        return low, high, slack - STRETCH_OFF, tense + STRETCH_OFF, deep + DEPTH_OFF

    @cached_property
    def _spanned(self) -> tuple[float, float]:
        """The stretches, m, at which the span lies within the table's."""
        spans, mount = read_table().spans, self.hand.mount_prestretch
        return float(spans[0]) - mount - _SAME, float(spans[-1]) - mount + _SAME

    @cached_property
    def grids(self) -> ForceGrids:
        """Splines over the hand's own forces."""
        return ForceGrids.of(self.hand, self.conditioned, self.range.stretch[1], np.array(self.covariance))

    @cached_property
    def _kept(self) -> dict[str, Any]:
        return {}


def _curves(model: MembraneModel, radius: float, stretch: float) -> tuple[list[Any], list[Any]]:
    """Return the pieces over depth of the logarithm and of its deviation; the last pair is kept."""
    key = (radius, stretch)
    known, found = model._kept.get("last", (None, ([], [])))  # at once: another thread may write it
    if known != key:
        grids = model.grids
        across = grids.diameter.weights(math.log(2 * radius))
        along = grids.stretch.weights(stretch)
        lines = [
            along @ (across @ values.reshape(len(across), -1)).reshape(values.shape[1:])
            for values in (grids.level, grids.spread)
        ]
        level, spread = ([*(grids.depth.pieces @ line).T.tolist(), line.tolist()] for line in lines)
        model._kept["last"] = key, (level, spread)
        return level, spread
    return found[0], found[1]


def _rising_from(level: Array, wanted: float) -> int | None:
    """Return the last of the stretches from which the logarithm of the force rises past a value, None where it does not.

    A membrane that hangs is met earlier the slacker it is, so that at a slight depth the force falls with stretch first.
    """
    passes = np.flatnonzero((level[:-1] <= wanted + _CLOSE) & (level[1:] >= wanted - _CLOSE))
    return int(passes[-1]) if passes.size else None
