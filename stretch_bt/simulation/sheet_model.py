"""The force model that solves the sheet itself, from its last press, with the hand that a calibration of the membrane model found."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from stretch_bt.errors import NoEquilibrium
from stretch_bt.model.force.force_model import require_force
from stretch_bt.model.force.membrane import MembraneModel
from stretch_bt.model.force.membrane_table import read_table
from stretch_bt.model.root import rising_root
from stretch_bt.quantity_text import format_quantity
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import MooneyRivlin
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.units import KINDS

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.result import SheetPress

__all__ = ["SheetModel"]

_LENGTH = KINDS["Length"]
_QUICK = Settings.within(0.01)
_EXACT = replace(_QUICK, exact=True)  # does not depend on earlier solves
_LIGHT = 2e-3  # m
_LEAST = 2.5e-4  # m; a lighter touch follows the table
_WIDE = 0.2  # part of the table's answer within which the sheet's is looked for first
_CLOSE = 1e-3  # relative difference of a force between solves of one press
_KEPT = 24  # stretches at which it is known how far the sheet hangs


@dataclass(frozen=True)
class SheetModel(MembraneModel):
    """Solves the sheet with its weight, bending and material for each force; friction and softening are factors from the table.

    Presses of neighbouring depths, stretches and radii start from each other. Both inverses are of exact solves. Where the
    table holds it agrees with the table; its use is that it does not rest on an interpolation.
    """

    kind: ClassVar[str] = "sheet"

    def predict(self, radius: float, stretch: float, depth: float) -> tuple[float, float]:
        """Return the force, N, and its standard deviation; from 2 mm on settled to about 0.1 %, as a tick wants, lighter exactly."""
        self.range.check(depth=depth)
        return self._told(radius, stretch, depth, _QUICK if depth >= _LIGHT else _EXACT)

    def _told(self, radius: float, stretch: float, depth: float, settings: Settings) -> tuple[float, float]:
        told, sd = super().predict(radius, stretch, depth)
        if depth == 0:
            return told, sd
        at = max(depth, _LEAST)
        bare, _ = self._bare.predict(radius, stretch, depth)
        lifted = bare / self._bare.predict(radius, stretch, at)[0] if at > depth else 1.0
        force = self._solved(radius, stretch, at, settings) * lifted * told / bare
        return force, sd * force / told

    def _past_spans(self, stretch: float) -> tuple[float, ...]:
        """Return no error: the sheet is solved at any span."""
        return ()

    def depth_for(self, radius: float, stretch: float, force: float) -> float:
        """Return the depth, m, at which the force, N, is this one."""
        require_force(force)
        self.range.check(radius=radius, stretch=stretch)
        if force == 0:
            return 0.0
        deepest = self.deepest(radius, stretch)
        most, told = (
            f[0] for f in (self._told(radius, stretch, deepest, _EXACT), super().predict(radius, stretch, deepest))
        )
        if force > most * (1 + _CLOSE):
            raise NoEquilibrium(
                f"{force:.3g} N is not reached at stretch {format_quantity(stretch, _LENGTH)}: at the deepest, "
                f"{format_quantity(deepest, _LENGTH)}, the force is {most:.3g} N"
            )
        near = super().depth_for(radius, stretch, min(force, told))
        return self._inverted(force, lambda d: self._told(radius, stretch, d, _EXACT)[0], near, 0.0, deepest)

    def stretch_for(self, radius: float, depth: float, force: float) -> float:
        """Return the stretch, m, at which the force, N, is this one."""
        require_force(force)
        self.range.check(radius=radius, depth=depth)
        ends = [self._told(radius, x, depth, _EXACT)[0] for x in self.range.stretch]
        if depth == 0 or not ends[0] * (1 - _CLOSE) <= force <= ends[1] * (1 + _CLOSE):
            raise NoEquilibrium(
                f"no stretch gives {force:.4g} N at a depth of {format_quantity(depth, _LENGTH)}; the calibrated "
                f"stretches give {ends[0]:.4g} to {ends[1]:.4g} N"
            )
        middle = sum(self.range.stretch) / 2
        return self._inverted(force, lambda x: self._told(radius, x, depth, _EXACT)[0], middle, *self.range.stretch)

    def _inverted(self, force: float, predict: Callable[[float], float], near: float, low: float, high: float) -> float:
        """Return where the force is reached, from a guess; between bounds that reach it."""

        def off(at: float) -> float:
            force_there = predict(at)
            return math.log(force_there / force) if force_there > 0 else -math.inf

        step = max(near * _WIDE, 1e-3)
        left, right = max(near - step, low), min(near + step, high)
        while left > low and off(left) > 0:
            left = max(left - 2 * (right - left), low)
        while right < high and off(right) < 0:
            right = min(right + 2 * (right - left), high)
        return rising_root(off, max(left, 1e-9), right)

    def _solved(self, radius: float, stretch: float, depth: float, settings: Settings) -> float:
        from stretch_bt.simulation.membrane.sheet.hanging import lowest
        from stretch_bt.simulation.membrane.sheet.result import Load
        from stretch_bt.simulation.membrane.sheet.solver import solve

        if stretch not in self._hangs:
            while len(self._hangs) >= _KEPT:
                del self._hangs[next(iter(self._hangs))]
            self._hangs[stretch] = lowest(self._sheet, stretch)
        load = Load(Sphere(2 * radius), stretch, depth, (0.0, 0.0), (0.0, 0.0), self._hangs[stretch])
        self._last[:] = [solve(self._sheet, load, settings, self._last[0] if self._last else None)]
        return float(self._last[0].force[2])

    @cached_property
    def _sheet(self) -> Sheet:
        table, hand = read_table(), self.hand
        material = MooneyRivlin(hand.shear_modulus, hand.second_invariant)
        effects = Effects(sag=table.density, bending=True)
        return Sheet(table.gauge, table.width, hand.thickness, material, hand.mount_prestretch, effects)

    @cached_property
    def _bare(self) -> MembraneModel:
        """The table's model without the effects that the sheet is not solved with."""
        hand = self.hand._replace(friction=0.0, softening=0.0)
        return MembraneModel(hand, self.covariance, self.relative_sd, self.range, self.provenance, self.conditioned)

    @cached_property
    def _last(self) -> list[SheetPress]:
        return []

    @cached_property
    def _hangs(self) -> dict[float, float]:
        return {}
