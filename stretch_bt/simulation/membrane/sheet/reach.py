"""Reaches a press in steps where it was not found at once, and distinguishes a hard press from one past its limit point."""

from __future__ import annotations

from collections.abc import Callable

from stretch_bt.errors import Impossible, NoEquilibrium
from stretch_bt.simulation.membrane.sheet.result import SheetPress

__all__ = ["BudgetSpent", "MeshTooCoarse", "reach"]

_FIRST = 0.5
_LEAST = 1 / 64
_WIDER = 1.5

Attempt = Callable[[float, SheetPress | None], SheetPress]


class MeshTooCoarse(NoEquilibrium):
    """None was found, and a finer mesh may find one."""


class BudgetSpent(Exception):
    """No iteration is left for another attempt."""


def reach(attempt: Attempt, failure: NoEquilibrium) -> SheetPress:
    """Return the press at the whole depth, which `attempt` solves at a part of it (0 to 1] from a shallower press.

    Raises
    ------
    NoEquilibrium
        No part of the depth has an equilibrium, and then `failure` says why; or none does past the part that is named.
    """
    reached, step, state = 0.0, _FIRST, None
    while step >= _LEAST:
        part = min(reached + step, 1.0)
        try:
            state = attempt(part, state)
        except Impossible:  # not reached yet, or lost
            if state is not None or part == 1.0:
                raise
        except NoEquilibrium as none:
            failure = none if state is not None else failure
            step = (part - reached) / 2
            continue
        except BudgetSpent as spent:
            why = f"; at a depth of {state.load.depth * 1e3:.3g} mm there is one" if state is not None else ""
            raise NoEquilibrium(f"{spent} before one was found{why}") from None
        reached, step = part, step * _WIDER
        if reached == 1.0 and state is not None:
            return state
    if state is None:
        raise failure
    past = f"past a depth of {state.load.depth * 1e3:.3g} mm"
    if isinstance(failure, MeshTooCoarse):
        raise MeshTooCoarse(f"{past} {failure.reason}")
    raise NoEquilibrium(
        f"{past} no equilibrium was found, as at a limit point or on a mesh too coarse: {failure.reason}"
    )
