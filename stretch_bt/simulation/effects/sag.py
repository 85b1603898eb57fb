"""The membrane hangs under its own weight."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import MembraneEffect, Size

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects

__all__ = ["Sag"]


class Sag(MembraneEffect):
    """The membrane hangs under its own weight."""

    name = "sag"
    order = 1
    cost_ms = 2.0
    cost_per = "solve"

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the sag of a membrane under tension, w L^2 / 8 T, as far as a press leaves of it, and its share of the depth.

        Where the membrane is held up by what it touches it no longer hangs; but it was met earlier by so much, and is pressed harder.
        """
        sag = case.sag
        why = f"hangs by {sag * 1e3:.2g} mm at a tension of {case.tension:.3g} N/m"
        yield Size("height", max(sag - case.depth, 0.0), why)
        yield from case.from_force(1.5 * sag / case.depth, why)

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        from stretch_bt.simulation.membrane.sheet.effects import DENSITY

        return replace(effects, sag=DENSITY)
