"""The membrane is softer where it has been stretched further before (Mullins)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import MembraneEffect, Size
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects

__all__ = ["Softening"]

_CYCLED = 0.5  # share of the first softening that comes back until the next task


class Parameters(base.Parameters):
    """Its softening."""

    share: Annotated[float, Within(0.001, 0.9)] = Field(
        default=0.1,
        description="part of its stress that the membrane loses where it has been stretched much further; 0.05 to 0.15 is usual",
    )


class Softening(MembraneEffect):
    """The membrane is softer where a press has stretched it further before (Mullins); stretching it in free air leaves no memory."""

    name = "mullins"
    order = 3
    cost_ms = 20.0
    cost_per = "reading"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the softening where presses deepen evenly: half of the first one in a membrane that has been cycled, over their number."""
        if case.scene.hand.conditioned is not None:
            yield from case.from_force(parameters.share, "the hand was pressed before the task")
            return
        presses = case.scene.conditions.presses
        part = _CYCLED * parameters.share / presses if presses > 1 else 0.0
        yield from case.from_force(part, f"{presses} presses, each deeper than the one before")

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        from stretch_bt.simulation.membrane.sheet.effects import Mullins

        return replace(effects, mullins=Mullins(r=1 / self.parameters.share))
