"""What stands in for a node: it takes its time, writes its outputs, and ends with its status."""

from __future__ import annotations

import re
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Any

import py_trees
from py_trees.common import Status

from stretch_bt.errors import UnsetKey
from stretch_bt.source import Map, Mark, Scalar, Value, did_you_mean
from stretch_bt.tree.context import Context
from stretch_bt.tree.countdown import Countdown
from stretch_bt.tree.flow.base import FlowNode
from stretch_bt.tree.ports import Cell
from stretch_bt.tree.types import Family, Type, attributes
from stretch_bt.tree.values import literal, refuse
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
    """Whether a pattern means a path; a pattern without an index means every index."""
    regex = ""
    for segment in pattern.split("/"):
        if segment == "**":
            regex += r"(?:[^/]+/)*"
        else:
            index = "" if segment.endswith("]") else r"(?:\[\d+\])?"
            regex += re.escape(segment).replace(r"\*", "[^/]*") + index + "/"
    return re.fullmatch(regex, path + "/") is not None


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
        return Estimate(fields["value"], fields["sd"])
    if type_.family is not Family.OBJECT or type_.cls is None:
        return literal(value, type_, what)
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
    return _Partial(cls.__name__, given)


class _FieldNotGiven(UnsetKey, AttributeError):
    """A field of a mocked object is read that the mocks file does not give."""


class _Partial:
    """An object of which a mocks file gives some fields."""

    def __init__(self, name: str, given: dict[str, Any]) -> None:
        self.__dict__.update(given)
        self._name = name

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
