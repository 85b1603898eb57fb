"""What stands in for a node: it takes its time, writes its outputs, and ends with its status."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import py_trees
from py_trees.common import Status

from stretch_bt.errors import UnsetKey
from stretch_bt.source import Map, Mark, Scalar, Seq, Value, did_you_mean
from stretch_bt.tree.cell import Cell
from stretch_bt.tree.context import Context
from stretch_bt.tree.countdown import Countdown
from stretch_bt.tree.flow.base import FlowNode
from stretch_bt.tree.types import Family, Type, attributes
from stretch_bt.tree.values import is_none, literal, refuse
from stretch_bt.units import Estimate

__all__ = ["Mock", "MockNode", "iter_then", "mock_value", "pattern_fits"]


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


def mock_value(value: Value, type_: Type, what: str) -> Any:
    """Return what a mock writes: a literal, `{value, sd}` of a number, or the fields of an object.

    Raises
    ------
    Refused
        The value does not fit the type; the diagnostic says where and what to write.
    """
    if type_.is_number and isinstance(value, Map):
        fields = {k.text: literal(v, type_, f"{what}.{k.text}") for k, v in value}
        if set(fields) != {"value", "sd"}:
            hint = "write '{value: 1 mm, sd: 0.1 mm}'"
            refuse(value.mark, "type-mismatch", f"{what} takes a value and its sd", hint)
        if fields["sd"] < 0:
            message = f"{what}.sd is a standard deviation, which is not below 0"
            refuse(value.mark, "out-of-bounds", message, "write '0' with its unit, or more")
        return Estimate(fields["value"], fields["sd"])
    if type_.item is not None and type_.is_record and isinstance(value, Seq):
        return [mock_value(item, type_.item, f"{what}[{i}]") for i, item in enumerate(value.items)]
    if type_.family is not Family.OBJECT or type_.cls is None:
        return None if is_none(value) else literal(value, type_, what)
    if not isinstance(value, Map):
        known = ", ".join(sorted(attributes(type_.cls))[:4])
        hint = f"write a mapping of some of {known}"
        refuse(value.mark, "type-mismatch", f"{what} takes the fields of a {type_}", hint)
    return _object(value, type_.cls, what)


def _object(value: Map, cls: type, what: str) -> Any:
    """Return an object with only the fields that the mock gives; reading another one says so."""
    known = attributes(cls)
    given = {}
    for key, inner in value:
        if key.text not in known:
            message = f"{cls.__name__} has no {key.text!r}"
            refuse(key.mark, "attribute-unknown", message, did_you_mean(key.text, known))
        given[key.text] = mock_value(inner, known[key.text], f"{what}.{key.text}")
    return _Partial(cls, given)


class _FieldNotGiven(UnsetKey, AttributeError):
    """A field of a mocked object is read that the mocks file does not give."""


class _Partial:
    """An object of which a mocks file gives some fields."""

    def __init__(self, cls: type, given: dict[str, Any]) -> None:
        self.__dict__.update(given)
        self._name = cls.__name__
        self._cls = cls

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # a node may write it to a port of its class
        return self._cls

    def __getattr__(self, field_name: str) -> Any:
        raise _FieldNotGiven(f"the mocked {self._name} gives no {field_name!r}; add it to the mock's outputs")


def iter_then(values: list[Any], then: str) -> Generator[Any, None, None]:
    """Yield the values, then what `then` says."""
    yield from values
    while True:
        yield from values if then == "cycle" else ([values[-1]] if then == "repeat_last" else [Status.FAILURE])


class MockNode(FlowNode):
    """Stands in for a node: takes its time, writes its outputs, ends with its status."""

    kind = "mock"

    def __init__(
        self,
        path: str,
        rule: Mock,
        outputs: list[tuple[Cell, list[Any]]],
        context: Context,
        script: Callable[[], bool] | None,
    ) -> None:
        super().__init__(path)
        self.rule = rule
        self.context = context
        self.script = script
        self.runs = 0
        self.limit = max((len(v) for _, v in outputs), default=0)
        by_outputs = self.limit > len(rule.statuses)  # then `then` speaks of the outputs
        self.statuses = iter_then(rule.statuses, "repeat_last" if by_outputs else rule.then)
        end = "repeat_last" if rule.then == "fail" else rule.then
        self.outputs = [(cell, iter_then(values, end)) for cell, values in outputs if values]

    def begin(self) -> None:
        """Start the time that the stand-in takes."""
        self.runs += 1
        self.time = Countdown(self.context, self.rule.after)

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Run until the time is over, then write and end."""
        yield from ()
        if not self.time.over:
            return Status.RUNNING
        status = self._status()
        if status is Status.SUCCESS:
            for cell, values in self.outputs:
                cell.write(next(values), self.path)
        elif status is Status.FAILURE:
            self.feedback_message = self.rule.message or "mocked failure"
        return status

    def _status(self) -> Status:
        if self.script is not None:
            return Status.SUCCESS if self.script() else Status.FAILURE
        if self.rule.then == "fail" and self.limit and self.runs > self.limit:
            return Status.FAILURE
        return next(self.statuses)  # type: ignore[no-any-return]
