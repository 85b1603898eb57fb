"""Compression of the membrane is relaxed to a tension field."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import MembraneEffect, Size

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects

__all__ = ["Wrinkling"]

_THERE, _MOST = 3e-5, 0.011  # relative change of the force times the strain; and that change in a sheet without tension


class Wrinkling(MembraneEffect):
    """Compression of the membrane is relaxed to a tension field."""

    name = "wrinkling"
    order = 0
    cost_ms = 1.0
    cost_per = "solve"

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the measured change of the force: 3e-5 over the strain, up to 1.1 % in a sheet without any."""
        part = min(_THERE / max(case.strain, 1e-9), _MOST)
        yield from case.from_force(part, f"strain {case.strain:.2g} along the membrane")

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, wrinkling=True)
