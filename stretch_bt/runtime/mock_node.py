"""What stands in for a node: it takes its time, writes its outputs, and ends with its status."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import py_trees
from py_trees.common import Status

from stretch_bt.source import Mark, Scalar, Value
from stretch_bt.tree.cell import Cell
from stretch_bt.tree.context import Context
from stretch_bt.tree.countdown import Countdown
from stretch_bt.tree.flow.base import FlowNode

__all__ = ["Mock", "MockNode", "iter_then", "pattern_fits"]


@dataclass(slots=True)
class Mock:
    """One rule of a mocks file."""

    pattern: str
    mark: Mark
    statuses: list[Status]
    status_when: Scalar | None = None
    after: float = 0.0
    outputs: dict[str, list[Value]] = field(default_factory=dict)
    output_marks: dict[str, Mark] = field(default_factory=dict)
    #: outputs that are written as a list, which ends even where it has one entry
    lists: set[str] = field(default_factory=set)
    status_is_list: bool = False
    then: str = "repeat_last"
    message: str = ""
    matched: int = 0
    known_outputs: set[str] = field(default_factory=set)

    def fits(self, path: str) -> bool:
        """Whether the pattern means this path."""
        return pattern_fits(self.pattern, path)


def pattern_fits(pattern: str, path: str) -> bool:
    """Whether a pattern means a path; a pattern without an index means every index.

    What stands between two `**` is looked for from the left; a place further right could not leave more room.
    """
    runs = _runs(pattern)
    segments = path.split("/")
    first, *middle = runs
    if not middle:
        return len(first) == len(segments) and _stands(first, segments, 0)
    *middle, last = middle
    end = len(segments) - len(last)
    if not (len(first) <= end and _stands(first, segments, 0) and _stands(last, segments, end)):
        return False
    at = len(first)
    for run in middle:
        found = next((k for k in range(at, end - len(run) + 1) if _stands(run, segments, k)), None)
        if found is None:
            return False
        at = found + len(run)
    return True


@lru_cache(maxsize=4096)
def _runs(pattern: str) -> tuple[tuple[str, ...], ...]:
    """Return the segments before, between and after each `**` of a pattern."""
    runs: list[list[str]] = [[]]
    for segment in pattern.split("/"):
        if segment == "**":
            runs.append([])
        else:
            runs[-1].append(segment)
    return tuple(tuple(run) for run in runs)


def _stands(run: tuple[str, ...], segments: list[str], at: int) -> bool:
    return all(_segment_fits(wanted, segments[at + k]) for k, wanted in enumerate(run))


def _segment_fits(wanted: str, name: str) -> bool:
    if wanted == name or _matches(wanted, name):
        return True
    bare = name.rpartition("[")[0] if name.endswith("]") and not wanted.endswith("]") else ""
    return bool(bare) and _matches(wanted, bare)


def _matches(wanted: str, name: str) -> bool:
    """Whether a name is the wanted one, in which each `*` stands for any letters."""
    first, *rest = wanted.split("*")
    if not rest:
        return wanted == name
    *middle, last = rest
    end = len(name) - len(last)
    if not (len(first) <= end and name.startswith(first) and name.endswith(last)):
        return False
    at = len(first)
    for part in middle:
        at = name.find(part, at, end)
        if at < 0:
            return False
        at += len(part)
    return True


def iter_then(values: list[Any], then: str) -> Generator[Any, None, None]:
    """Yield the values, then what `then` says."""
    yield from values
    while True:
        yield from values if then == "cycle" else ([values[-1]] if then == "repeat_last" else [Status.FAILURE])


class MockNode(FlowNode):
    """Stands in for a node: takes its time, writes its outputs, ends with its status; `limit` starts use up its shortest list of outputs."""

    kind = "mock"

    def __init__(
        self,
        path: str,
        rule: Mock,
        outputs: list[tuple[Cell, list[Any]]],
        limit: int,
        context: Context,
        script: Callable[[], bool] | None,
    ) -> None:
        super().__init__(path)
        self.rule = rule
        self.context = context
        self.script = script
        self.runs = 0
        self.limit = limit
        by_outputs = limit and not rule.status_is_list  # then `then` speaks of the outputs alone
        self.statuses = iter_then(rule.statuses, "repeat_last" if by_outputs else rule.then)
        end = "repeat_last" if rule.then == "fail" else rule.then
        self.outputs = [(cell, iter_then(values, end)) for cell, values in outputs if values]

    def begin(self) -> None:
        """Start the time that the stand-in takes."""
        self.runs += 1
        self.due: Status | None = None
        self.time = Countdown(self.context, self.rule.after)
        self.values = [(cell, next(values)) for cell, values in self.outputs]

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Run until the time is over, then write and end."""
        yield from ()
        if not self.time.over:
            return Status.RUNNING
        status = self._status()
        if status is Status.SUCCESS:
            for cell, value in self.values:
                if value is None:
                    cell.unset(self.path)
                else:
                    cell.write(value, self.path)
        elif status is Status.FAILURE:
            self.feedback_message = self.rule.message or "mocked failure"
        return status

    def _status(self) -> Status:
        if self.rule.then == "fail" and self.limit and self.runs > self.limit:
            return Status.FAILURE
        if self.script is not None:
            return Status.SUCCESS if self.script() else Status.FAILURE
        if self.due is None:
            self.due = next(self.statuses)
        return self.due
