"""The force model that solves the sheet itself, from its last press, with the hand that a calibration of the membrane model found."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from stretch_bt.model.membrane import MembraneModel
from stretch_bt.model.membrane_table import read_table
from stretch_bt.model.root import rising_root
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import MooneyRivlin
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.settings import Settings

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.result import SheetPress

__all__ = ["SheetModel"]

_SETTINGS = Settings.within(0.01)
_LEAST = 2.5e-4  # m; a lighter touch follows the table
_WIDE = 1.2  # of the table's answer, that the sheet's is looked for within


@dataclass(frozen=True)
class SheetModel(MembraneModel):
    """Solves the sheet with its weight, bending and material for each force; friction and softening are parts, by the table.

    Presses of neighbouring depths, stretches and radii start from each other. Where the table holds it says nothing else; its
    use is that it does not rest on an interpolation.
    """

    kind: ClassVar[str] = "sheet"

    def predict(self, radius: float, stretch: float, depth: float) -> tuple[float, float]:
        """Return the force, N, and its standard deviation."""
        told, sd = super().predict(radius, stretch, depth)
        if depth == 0:
            return told, sd
        at = max(depth, _LEAST)
        bare, _ = self._bare.predict(radius, stretch, depth)
        lifted = bare / self._bare.predict(radius, stretch, at)[0] if at > depth else 1.0
        force = self._solved(radius, stretch, at) * lifted * told / bare
        return force, sd * force / told

    def depth_for(self, radius: float, stretch: float, force: float) -> float:
        """Return the depth, m, at which the force, N, is this one."""
        near = super().depth_for(radius, stretch, force)
        deepest = self.deepest(radius, stretch)
        return self._inverted(force, lambda d: self.predict(radius, stretch, d)[0], near, 0.0, deepest)

    def stretch_for(self, radius: float, depth: float, force: float) -> float:
        """Return the stretch, m, at which the force, N, is this one."""
        near = super().stretch_for(radius, depth, force)
        return self._inverted(force, lambda x: self.predict(radius, x, depth)[0], near, *self.range.stretch)

    def _inverted(self, force: float, predict: Callable[[float], float], near: float, low: float, high: float) -> float:
        """Return where the force is reached, beside the table's answer."""
        if force == 0:
            return near
        step = max(near * (_WIDE - 1), 1e-3)
        ends = max(near - step, low), min(near + step, high)
        return rising_root(lambda at: math.log(max(predict(at), 1e-300) / force), *ends)

    def _solved(self, radius: float, stretch: float, depth: float) -> float:
        from stretch_bt.simulation.membrane.sheet.hanging import hang
        from stretch_bt.simulation.membrane.sheet.result import Load
        from stretch_bt.simulation.membrane.sheet.solver import solve

        if stretch not in self._hangs:
            self._hangs[stretch] = -float(hang(self._sheet, stretch).points(9, 41)[..., 2].min())
        load = Load(Sphere(2 * radius), stretch, depth, (0.0, 0.0), (0.0, 0.0), self._hangs[stretch])
        self._last[:] = [solve(self._sheet, load, _SETTINGS, self._last[0] if self._last else None)]
        return float(self._last[0].force[2])

    @cached_property
    def _sheet(self) -> Sheet:
        table, hand = read_table(), self.hand
        material = MooneyRivlin(hand.shear_modulus, hand.second_invariant)
        effects = Effects(sag=table.density, bending=True)
        return Sheet(table.gauge, table.width, hand.thickness, material, hand.mount_prestretch, effects)

    @cached_property
    def _bare(self) -> MembraneModel:
        """The table's model without what the sheet is not solved with."""
        hand = self.hand._replace(friction=0.0, softening=0.0)
        return MembraneModel(hand, self.covariance, self.relative_sd, self.range, self.provenance, self.conditioned)

    @cached_property
    def _last(self) -> list[SheetPress]:
        return []

    @cached_property
    def _hangs(self) -> dict[float, float]:
        return {}
