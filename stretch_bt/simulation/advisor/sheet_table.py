"""The measured error and cost of each setting of the sheet: the data that `benchmarks/sheet_tolerance.py` makes."""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from math import prod
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stretch_bt.simulation.advisor.case import Case

__all__ = ["SheetTable", "read_sheet_table"]

#: with either of these each reading is a solve of its own: together they take as long as the longer one
_REMEMBER = ("friction", "mullins")
_ROUNDNESS = 0.1  # over a force's relative change: how much rolling rounds a lump goes as the logarithm of the force


@dataclass(frozen=True, slots=True)
class SheetTable:
    """Errors of presses against much finer ones, and CPU times.

    Parameters
    ----------
    stretches
        Where each range of stretch but the first begins, m.
    errors
        By rung and by the shape that holds the membrane up, for each range of stretch: the 95th percentile of the error of the `force`, a part of it,
        and of `height` and `size`, m, of `n` presses.
    press_ms
        By rung, for each range of stretch: CPU time of a press without effects, ms.
    factors
        By effect: how many times as long a press takes with it.
    """

    stretches: tuple[float, ...]
    errors: Mapping[str, Mapping[str, tuple[Mapping[str, float], ...]]]
    press_ms: Mapping[str, tuple[float, ...]]
    factors: Mapping[str, float]

    def error(self, rung: str, case: Case) -> dict[str, float]:
        """Return the 95th percentile of the error of each result of a press, SI; empty without a sheet or a measurement."""
        shapes = self.errors.get(rung, {})
        if case.rough.holds not in shapes:
            return {}
        found = dict(shapes[case.rough.holds][self._range(case)])
        return {**found, "stiffness": found["force"], "roundness": _ROUNDNESS * found["force"]}

    def cost(self, rung: str, on: Collection[str], case: Case) -> float:
        """Return about how long a press takes with some effects on, ms of CPU; 0 without a sheet."""
        base = self.press_ms.get(rung)
        return 0.0 if base is None else base[self._range(case)] * self.times(on)

    def times(self, on: Collection[str]) -> float:
        """Return how many times as long a press takes with some effects on."""
        remembering = max((self.factor(name) for name in _REMEMBER if name in on), default=1.0)
        return remembering * prod(self.factor(name) for name in on if name not in _REMEMBER)

    def factor(self, effect: str) -> float:
        """Return how many times as long a press takes with an effect, at least once."""
        return max(self.factors.get(effect, 1.0), 1.0)

    def _range(self, case: Case) -> int:
        return bisect_right(self.stretches, case.stretch)


@lru_cache(maxsize=1)
def read_sheet_table() -> SheetTable:
    """Return the committed table."""
    read = json.loads((files("stretch_bt.simulation.advisor") / "data" / "sheet.json").read_text("utf-8"))
    errors = {rung: {holds: tuple(rows) for holds, rows in shapes.items()} for rung, shapes in read["errors"].items()}
    press_ms = {rung: tuple(times) for rung, times in read["press_ms"].items()}
    return SheetTable(tuple(read["stretches"]), errors, press_ms, read["factors"])
