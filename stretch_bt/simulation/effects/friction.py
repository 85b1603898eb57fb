"""The membrane sticks to the object as far as Coulomb lets it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import MembraneEffect, Size
from stretch_bt.units import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects

__all__ = ["Friction"]


class Parameters(base.Parameters):
    """Coulomb's coefficient."""

    coefficient: Annotated[float, Within(0.0, 5.0)] = Field(
        default=0.5, description="0.25 to 0.75 is usual for silicone"
    )


class Friction(MembraneEffect):
    """The membrane sticks to the object as far as Coulomb lets it."""

    name = "friction"
    order = 4
    cost_ms = 50.0
    cost_per = "reading"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the measured excess of the force: 1.9 % at a coefficient of 0.5, 3.7 % where nothing slides."""
        part = min(0.038 * parameters.coefficient, 0.037)
        yield from case.from_force(part, f"a coefficient of {parameters.coefficient:g}")

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, friction=self.parameters.coefficient)
