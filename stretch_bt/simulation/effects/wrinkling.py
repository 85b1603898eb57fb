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

#: relative change of the force, times the strain; and that change where nothing but its own weight stretches the sheet
_THERE, _HANGING = 3e-5, 0.07
_LENGTH = 0.021  # m, change of a length at four fifths of the depth over that of the force


class Wrinkling(MembraneEffect):
    """Compression of the membrane is relaxed to a tension field."""

    name = "wrinkling"
    order = 0
    cost_ms = 1.0
    cost_per = "solve"

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the measured change of the force: 3e-5 over the strain, up to 7 % in a sheet that hangs without any.

        A press stretches such a sheet, and the deeper it is the less of its force is the weight of a sheet that hangs in folds.
        """
        most = _HANGING * case.weight / 2 / (case.weight / 2 + case.force)
        part = min(_THERE / max(case.strain, 1e-9), most)
        why = f"strain {case.strain:.2g} along the membrane"
        yield from case.from_force(part, why)
        yield Size("size", _LENGTH * part, why)

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, wrinkling=True)
