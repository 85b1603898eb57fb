"""The dough sticks to the hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.units import Force, Within

__all__ = ["Tack"]


class Parameters(base.Parameters):
    """The pull of what sticks, N."""

    pull: Annotated[Force, Within(0.0, 5.0, "Force")] = Field(
        default=0.1, description="by which the force of a press is lessened at most; 0.05 to 0.2 N is an assumption"
    )


class Tack(ObjectEffect):
    """The dough sticks to the hand: it lessens the force of a light press; the pull on a hand that lifts is not felt."""

    name = "tack"
    needs = "plasticity"
    order = 13
    cost_ms = 0.001
    cost_per = "solve"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the pull over the force of the deepest press."""
        part = min(parameters.pull / case.force, 1.0)
        yield from case.from_force(part, f"pull over force {part:.2g}")
