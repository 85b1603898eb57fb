"""The membrane is softer where it has been stretched further before (Mullins)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import MembraneEffect, Size

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects

__all__ = ["Softening"]

_SOFTENING = 0.05


class Softening(MembraneEffect):
    """The membrane is softer where it has been stretched further before (Mullins)."""

    name = "mullins"
    order = 3
    cost_ms = 20.0
    cost_per = "reading"

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the softening where presses deepen evenly: 5 % at most in a membrane that has been cycled, over their number."""
        presses = case.scene.conditions.presses
        part = _SOFTENING / presses if presses > 1 else 0.0
        yield from case.from_force(part, f"{presses} presses, each deeper than the one before")

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        from stretch_bt.simulation.membrane.sheet.effects import Mullins

        return replace(effects, mullins=Mullins())
