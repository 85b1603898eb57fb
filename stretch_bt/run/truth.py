"""Outputs of a run, with their standard deviations, beside what the scene knew at the moment each was written."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from stretch_bt.errors import NoAnswer
from stretch_bt.run.onlooker import Onlooker
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.document import Declared
from stretch_bt.units import parse_unit

__all__ = ["Truths", "output_values"]


class Truths(Onlooker):
    """A watcher that asks the scene for the truth whenever an output is written; the last write counts.

    Outputs that the scene alone knows are asked for at every one of these moments.
    """

    def __init__(self, outputs: Mapping[str, tuple[Declared, Cell]], truth: Callable[[], Mapping[str, float]]) -> None:
        self.names = {cell.name: name for name, (_, cell) in outputs.items()}
        self.own = [name for name, (declared, _) in outputs.items() if declared.scene]
        self.truth = truth
        self.found: dict[str, float] = {}

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Ask for the truth of an output."""
        name = self.names.get(key)
        if name is None:
            return
        if value is None:  # the output is left without a value, and so is what it was held against
            self.found.pop(name, None)
            return
        try:
            known = self.truth()
        except NoAnswer:  # the scene has no answer where the hand stands
            return
        for asked in (name, *self.own):
            if asked in known and math.isfinite(known[asked]):
                self.found[asked] = known[asked]


def output_values(
    outputs: Mapping[str, tuple[Declared, Cell]], truths: Mapping[str, float], *, succeeded: bool
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (outputs, truth) as {name: {value, unit, sd}}, in the unit that each is shown in.

    A default that nothing overwrote is an output of a task that `succeeded` alone.
    """
    values, known = {}, {}
    for name, (declared, cell) in outputs.items():
        unit, scale = shown_in(declared)
        if declared.scene and name in truths:
            values[name] = {"value": _scaled(truths[name], scale), "unit": unit, "sd": None}
        elif cell.value is not MISSING and (succeeded or cell.writer):
            values[name] = {"value": _scaled(cell.value, scale), "unit": unit, "sd": _scaled(cell.sd, scale)}
        if name in truths:
            known[name] = {"value": _scaled(truths[name], scale), "unit": unit, "sd": None}
    return values, known


def shown_in(declared: Declared) -> tuple[str, float]:
    """Return the unit that an output is shown in, and its SI value."""
    kind = declared.type.kind
    unit = declared.unit or (kind.unit if kind else "")
    return unit, parse_unit(unit)[0] if unit else 1.0


def _scaled(value: Any, scale: float) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return value if scale == 1.0 else value / scale
