"""The dough sticks to the hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.units import Force
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.scene.file import Scene

__all__ = ["Tack"]


class Parameters(base.Parameters):
    """Adhesion, N: the pull of the hand, and the hold of the table."""

    pull: Annotated[Force, Within(0.0, 5.0, "Force")] = Field(
        default=0.1,
        description="pull at which hand and dough come apart, and largest loss of a press' force; 0.05 to 0.2 N is an assumption",
    )
    hold: Annotated[Force, Within(0.0, 5.0, "Force")] = Field(
        default=0.1, description="force of the table's hold beside its weight; 0 N on flour"
    )


class Tack(ObjectEffect):
    """The dough sticks to the hand: it lessens a light press and pulls at a hand that lifts; with a pull above weight and hold it comes along.

    A membrane under a tension T peels off a ball of radius R at pi W R, whatever T, for a work of adhesion W, J/m^2: at its edge of radius
    a its angle to the ball is sqrt(2 W / T), of which a / R is the ball's and F / (2 pi a T) the pull's. So 0.1 N on a ball of 31 mm
    are 2 J/m^2; between solids it would be 1.5 pi W R (Johnson, Kendall and Roberts 1971).
    """

    name = "tack"
    order = 13
    cost_ms = 0.001
    cost_per = "solve"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def not_at(cls, scene: Scene) -> str | None:
        """Only the sheet has a shape for a membrane that is pulled down."""
        return None if scene.is_sheet else f"{scene.fidelity} fidelity has no membrane that is pulled down"

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the pull over the force of the deepest press; of dough that comes along, its own height."""
        part = min(parameters.pull / case.force, 1.0)
        yield from case.from_force(part, f"pull over force {part:.2g}")
        held = case.rough.weight + parameters.hold
        if parameters.pull > held:
            yield Size(
                "height", 2 * case.rough.radius, f"it comes along: pull {parameters.pull:.2g} N, held by {held:.2g} N"
            )
