"""What an object that changes its shape looked like in the course of a run, for the report."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from stretch_bt.runtime.onlooker import Onlooker

__all__ = ["SKETCHES", "Sketches"]

SKETCHES = "sketches.json"
APART = 2.0  # s between sketches, but for the last

Lines = Mapping[str, Sequence[tuple[float, float]]]


class Sketches(Onlooker):
    """A watcher that has the object drawn when an output is written, the latest always and others a while apart."""

    def __init__(self, outputs: Collection[str], sketch: Callable[[], Lines]) -> None:
        self.outputs, self.sketch = outputs, sketch
        self.time = 0.0
        self.kept: list[tuple[float, Lines]] = []
        self.last: tuple[float, Lines] | None = None

    def begin_tick(self, tick: int, time: float) -> None:
        """Know the time."""
        self.time = time

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Draw."""
        if key not in self.outputs or (self.last is not None and self.last[0] == self.time):
            return
        lines = self.sketch()
        if not lines:
            return
        self.last = (self.time, lines)
        if not self.kept or self.time >= self.kept[-1][0] + APART:
            self.kept.append(self.last)

    def save(self, folder: Path) -> None:
        """Write what there is into the folder of the record; nothing of an object that keeps its shape."""
        if self.last is None:
            return
        shown = [*self.kept, self.last] if self.kept[-1] is not self.last else self.kept
        rows = [{"time": time, **{name: _rounded(line) for name, line in lines.items()}} for time, lines in shown]
        (folder / SKETCHES).write_text(json.dumps(rows) + "\n", encoding="utf-8")


def _rounded(line: Sequence[tuple[float, float]]) -> list[list[float]]:
    return [[round(x, 6), round(y, 6)] for x, y in line]
