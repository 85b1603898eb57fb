"""Mocks by path pattern: any node of an unedited tree is replaced, without a device or a scene.

A pattern is a path in which `*` stands for one segment and `**` for any number; `fit_sphere[1]` is the second of its
name in its place. A pattern that matches nothing is an error.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import py_trees
from py_trees.common import Status

from stretch_bt.errors import Diagnostic, FileError, MocksError, TreeError, UnsetKey
from stretch_bt.source import Map, Mark, Scalar, Seq, Value, did_you_mean, load
from stretch_bt.tree.build import Builder
from stretch_bt.tree.context import Context
from stretch_bt.tree.expression import ExpressionError, bind, parse, typecheck
from stretch_bt.tree.flow import Part
from stretch_bt.tree.flow.base import FlowNode
from stretch_bt.tree.ports import Cell
from stretch_bt.tree.program import Program, find_tree
from stretch_bt.tree.types import BOOL, Family, Type, attributes, quantity
from stretch_bt.tree.values import Refused, literal
from stretch_bt.units import KINDS, Estimate

__all__ = ["FORMAT", "Expectation", "MockNode", "Mocks", "read_mocks"]

FORMAT = "stretch-mocks/1"
TOP = ("format", "doc", "tree", "mocks", "readings", "expect")
FIELDS = ("match", "status", "status_when", "after", "outputs", "then", "message")
THEN = ("repeat_last", "cycle", "fail")
STATUSES = {"success": Status.SUCCESS, "failure": Status.FAILURE, "running": Status.RUNNING}
TIME = quantity(KINDS["Time"].dimension)


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


@dataclass(slots=True)
class Expectation:
    """What a mocks file says of the run: its result, what was visited, what never, and how many ticks at most."""

    result: str | None = None
    visited: list[tuple[str, str | None]] = field(default_factory=list)
    never: list[tuple[str, str | None]] = field(default_factory=list)
    ticks_max: int | None = None

    def unmet(self, status: str, ticks: int, seen: set[tuple[str, str]]) -> list[str]:
        """Return what did not come true; `seen` holds (path, STATUS) of every change."""
        found = []
        if self.result is not None and status.lower() != self.result:
            found.append(f"expected {self.result}, the run ended with {status.lower()}")
        found += [f"expected a visit of {_show(p)}" for p in self.visited if not _seen(p, seen)]
        found += [f"expected no visit of {_show(p)}" for p in self.never if _seen(p, seen)]
        if self.ticks_max is not None and ticks > self.ticks_max:
            found.append(f"expected at most {self.ticks_max} ticks, took {ticks}")
        return found


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


def _seen(wanted: tuple[str, str | None], seen: set[tuple[str, str]]) -> bool:
    pattern, status = wanted
    return any(pattern_fits(pattern, path) and status in (None, s.lower()) for path, s in seen)


def _show(wanted: tuple[str, str | None]) -> str:
    return wanted[0] + (f"#{wanted[1]}" if wanted[1] else "")


class Mocks:
    """A mocks file, as substitutes for a builder."""

    def __init__(self, file: str, tree: Scalar | None, path: Path) -> None:
        self.file = file
        self.tree = tree
        self.path = path
        self.rules: list[Mock] = []
        self.readings: dict[str, list[float]] = {}
        self.expect = Expectation()
        self.diagnostics: list[Diagnostic] = []
        self.replaced: list[str] = []

    def rule(self, path: str) -> Mock | None:
        """Return the first rule whose pattern means this path."""
        for rule in self.rules:
            if rule.fits(path):
                rule.matched += 1
                self.replaced.append(path)
                return rule
        return None

    def node(self, path: str, part: Part, builder: Builder) -> py_trees.behaviour.Behaviour | None:
        """Return a stand-in for the node at this path, or None."""
        rule = self.rule(path)
        if rule is None:
            return None
        sinks = builder.outputs(part)
        rule.known_outputs.update(sinks)
        outputs = [
            self._output(rule, name, cell, type_) for name, (cell, type_) in sinks.items() if name in rule.outputs
        ]
        for name, (cell, _) in sinks.items():
            if name not in rule.outputs:
                cell.blocked = f"the mock of {path} gives no output {name!r}"
        return MockNode(path, rule, outputs, builder.context, self._script(rule, builder))

    def condition(self, path: str, builder: Builder) -> Callable[[], bool] | None:
        """Return a stand-in for the condition at this path, or None."""
        rule = self.rule(path)
        if rule is None:
            return None
        script = self._script(rule, builder)
        statuses = iter_then(rule.statuses, rule.then)
        return script or (lambda: next(statuses) is Status.SUCCESS)

    def attach(self, readings: dict[str, Callable[[], float]]) -> None:
        """Put the mocked readings where expressions find them."""
        for name, values in self.readings.items():
            given = iter_then(values, "repeat_last")
            readings[name] = lambda given=given: next(given)  # type: ignore[misc]

    def check_matches(self, paths: list[str]) -> None:
        """Note every rule that replaced nothing, with the closest path."""
        for rule in self.rules:
            if rule.matched == 0:
                plain = rule.pattern.replace("**/", "")
                close = difflib.get_close_matches(rule.pattern, paths, n=1, cutoff=0.3) or difflib.get_close_matches(
                    plain, {p.rpartition("/")[2]: p for p in paths}, n=1, cutoff=0.3
                )
                by_tail = {p.rpartition("/")[2]: p for p in paths}
                hint = (
                    f"closest path: {by_tail.get(close[0], close[0])}"
                    if close
                    else "`stretch-bt show TREE` lists the paths"
                )
                self._error(rule.mark, "mock-unmatched", f"pattern {rule.pattern!r} matches no node", hint)
            for name in rule.outputs if rule.matched else ():
                if name not in rule.known_outputs:
                    self._unknown_output(name, rule.output_marks[name], rule.pattern, sorted(rule.known_outputs))
        if self.diagnostics:
            raise MocksError(self.diagnostics)

    def _error(self, mark: Mark, code: str, message: str, hint: str) -> None:
        self.diagnostics.append(mark.error(code, message, hint))

    def _unknown_output(self, name: str, mark: Mark, pattern: str, known: list[str]) -> None:
        hint = did_you_mean(name, known) or "the tree wires no output of it"
        self._error(mark, "port-unknown", f"{pattern!r} writes no output {name!r} in this tree", hint)

    def _output(self, rule: Mock, name: str, cell: Cell, type_: Type) -> tuple[Cell, list[Any]]:
        values = []
        for value in rule.outputs[name]:
            try:
                values.append(_value(value, type_, name))
            except Refused as refused:
                self.diagnostics.append(refused.diagnostic)
        return cell, values

    def _script(self, rule: Mock, builder: Builder) -> Callable[[], bool] | None:
        if rule.status_when is None:
            return None
        text = rule.status_when
        try:
            expression = parse(text.text)
            if typecheck(expression, builder.frame.scope) is not BOOL:
                self._error(
                    text.mark, "type-mismatch", f"{text.text!r} is not true or false", "compare it with something"
                )
                return None
        except ExpressionError as error:
            self._error(text.mark.shifted(error.offset, error.length), error.code, error.message, error.hint)
            return None
        return bind(expression, builder)


def _value(value: Value, type_: Type, what: str) -> Any:
    """Return what a mock writes: a literal, `{value, sd}` of a number, or the fields of an object."""
    if type_.is_number and isinstance(value, Map):
        fields = {k.text: literal(v, type_, f"{what}.{k.text}") for k, v in value}
        if set(fields) != {"value", "sd"}:
            raise Refused(
                value.mark.error("type-mismatch", f"{what} takes a value and its sd", "write {value: 1 mm, sd: 0.1 mm}")
            )
        return Estimate(fields["value"], fields["sd"])
    if type_.family is not Family.OBJECT or type_.cls is None:
        return literal(value, type_, what)
    if not isinstance(value, Map):
        raise Refused(
            value.mark.error("type-mismatch", f"{what} takes the fields of a {type_}", "write {field: value}")
        )
    return _object(value, type_.cls, what)


def _object(value: Map, cls: type, what: str) -> Any:
    """Return an object with only the fields that the mock gives; reading another one says so."""
    known = attributes(cls)
    given = {}
    for key, inner in value:
        if key.text not in known:
            raise Refused(
                key.mark.error(
                    "attribute-unknown", f"{cls.__name__} has no {key.text!r}", did_you_mean(key.text, known)
                )
            )
        given[key.text] = _value(inner, known[key.text], f"{what}.{key.text}")
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
        longest = max((len(v) for _, v in outputs), default=0)
        by_outputs = longest > len(rule.statuses)  # then `then` speaks of the outputs
        self.statuses = iter_then(rule.statuses, "repeat_last" if by_outputs else rule.then)
        end = "repeat_last" if rule.then == "fail" else rule.then
        self.outputs = [(cell, iter_then(values, end)) for cell, values in outputs if values]
        self.limit = max((len(v) for _, v in outputs), default=0)
        self.until = 0.0

    def begin(self) -> None:
        """Start the time that the stand-in takes."""
        self.runs += 1
        self.until = self.context.now + self.rule.after

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Run until the time is over, then write and end."""
        yield from ()
        if self.context.now < self.until - 1e-9:
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


def read_mocks(path: Path, name: str | None = None) -> Mocks:
    """Read a mocks file; raises MocksError with every mistake."""
    try:
        root = load(path, name)
    except FileError as error:
        raise MocksError(error.diagnostics) from None
    found = _Reader(root, name or str(path), path).read()
    if found.diagnostics:
        raise MocksError(found.diagnostics)
    return found


class _Reader:
    def __init__(self, root: Map, file: str, path: Path) -> None:
        tree = root.get("tree")
        self.root = root
        self.found = Mocks(file, tree if isinstance(tree, Scalar) else None, path)

    def error(self, mark: Mark, code: str, message: str, hint: str = "") -> None:
        self.found.diagnostics.append(mark.error(code, message, hint))

    def read(self) -> Mocks:
        self.known(self.root, TOP, "a mocks file")
        form = self.root.get("format")
        if not isinstance(form, Scalar) or form.text != FORMAT:
            self.error(
                form.mark if form else self.root.mark,
                "format-unknown",
                "this is not a mocks file",
                f"begin with 'format: {FORMAT}'",
            )
        if self.found.tree is None:
            self.error(
                self.root.mark,
                "key-missing",
                "the tree that these mocks are for is missing",
                "add 'tree: palpate_stiffness'",
            )
        for item in self.items(self.root.get("mocks"), "mocks"):
            self.rule(item)
        self.readings(self.root.get("readings"))
        self.expect(self.root.get("expect"))
        return self.found

    def known(self, value: Map, known: tuple[str, ...], what: str) -> None:
        for key, _ in value:
            if key.text not in known:
                self.error(key.mark, "key-unknown", f"{what} has no {key.text!r}", did_you_mean(key.text, known))

    def items(self, value: Value | None, what: str) -> list[Value]:
        if value is None:
            return []
        if isinstance(value, Seq):
            return list(value.items)
        self.error(value.mark, "type-mismatch", f"{what!r} takes a list", "begin each entry with '- '")
        return []

    def rule(self, value: Value) -> None:
        if not isinstance(value, Map):
            self.error(
                value.mark, "type-mismatch", "a mock is a mapping", "write '- {match: \"**/press\", status: success}'"
            )
            return
        self.known(value, FIELDS, "a mock")
        match = value.get("match")
        if not isinstance(match, Scalar) or not match.text:
            self.error(value.mark, "key-missing", "a mock needs 'match'", "add 'match: \"**/press\"'")
            return
        rule = Mock(match.text, match.mark, self.statuses(value.get("status")))
        when = value.get("status_when")
        rule.status_when = when if isinstance(when, Scalar) else None
        if when is not None and "status" in value:
            self.error(when.mark, "key-duplicate", "'status' and 'status_when' exclude each other", "keep one")
        self.options(rule, value)
        self.found.rules.append(rule)

    def options(self, rule: Mock, value: Map) -> None:
        try:
            after = value.get("after")
            rule.after = literal(after, TIME, "after") if after is not None else 0.0
        except Refused as refused:
            self.found.diagnostics.append(refused.diagnostic)
        rule.then = self.option(value.get("then"), THEN, "then", "repeat_last")
        message = value.get("message")
        rule.message = message.text if isinstance(message, Scalar) else ""
        outputs = value.get("outputs")
        if outputs is not None and not isinstance(outputs, Map):
            self.error(
                outputs.mark, "type-mismatch", "'outputs' takes a mapping from ports to values", "write {height: 20 mm}"
            )
        for key, given in outputs if isinstance(outputs, Map) else ():
            rule.outputs[key.text] = list(given.items) if isinstance(given, Seq) else [given]
            rule.output_marks[key.text] = key.mark
            if not rule.outputs[key.text]:
                self.error(given.mark, "empty", f"{key.text!r} has no values", "write at least one")

    def option(self, value: Value | None, options: tuple[str, ...], what: str, default: str) -> str:
        if value is None:
            return default
        if isinstance(value, Scalar) and value.text in options:
            return value.text
        given = value.text if isinstance(value, Scalar) else "this"
        self.error(value.mark, "option-unknown", f"{given!r} is not a {what}", did_you_mean(given, options))
        return default

    def statuses(self, value: Value | None) -> list[Status]:
        given = list(value.items) if isinstance(value, Seq) else [value]
        return [STATUSES[self.option(item, tuple(STATUSES), "status", "success")] for item in given] or [Status.SUCCESS]

    def readings(self, value: Value | None) -> None:
        from stretch_bt.hardware.interfaces import INTERFACES, readings_of
        from stretch_bt.tree.types import from_annotation

        types = {n: from_annotation(a) for i in INTERFACES.values() for n, a in readings_of(i).items()}
        for key, given in value if isinstance(value, Map) else ():
            type_ = types.get(key.text.rpartition(".")[2])
            if type_ is None:
                self.error(key.mark, "name-unknown", f"{key.text!r} is not a reading", "write 'arm.force: 1 N'")
                continue
            try:
                values = given.items if isinstance(given, Seq) else (given,)
                self.found.readings[key.text] = [literal(v, type_, key.text) for v in values]
            except Refused as refused:
                self.found.diagnostics.append(refused.diagnostic)

    def expect(self, value: Value | None) -> None:
        if value is None:
            return
        if not isinstance(value, Map):
            self.error(value.mark, "type-mismatch", "'expect' takes a mapping", "write {result: success}")
            return
        self.known(value, ("result", "visited", "never", "ticks_max"), "expect")
        wanted = self.found.expect
        if "result" in value:
            results = ("success", "failure", "error", "fault", "interrupted")
            wanted.result = self.option(value.get("result"), results, "result", "success")
        for name in ("visited", "never"):
            for item in self.items(value.get(name), name):
                if isinstance(item, Scalar):
                    pattern, _, status = item.text.partition("#")
                    getattr(wanted, name).append((pattern, status or None))
        ticks = value.get("ticks_max")
        if isinstance(ticks, Scalar) and isinstance(ticks.value, int):
            wanted.ticks_max = ticks.value
        elif ticks is not None:
            self.error(ticks.mark, "type-mismatch", "ticks_max takes a whole number", "write 'ticks_max: 400'")


def tree_of(mocks: Mocks) -> str | Path:
    """Return the tree that a mocks file is for: a path beside it, or the name of a shipped one."""
    assert mocks.tree is not None
    beside = mocks.path.parent / mocks.tree.text
    if mocks.tree.text.endswith((".yaml", ".yml")) and beside.exists():
        return beside
    try:
        return find_tree(mocks.tree.text)[0]
    except TreeError as error:
        raise MocksError(
            [mocks.tree.mark.error("file-missing", f"no tree {mocks.tree.text!r}", error.diagnostics[0].hint)]
        ) from None


def check_mocks(mocks: Mocks, program: Program) -> None:
    """Build the program with the mocks, so that every pattern and output is matched; raises MocksError."""
    from stretch_bt.run.context import RunContext
    from stretch_bt.tree.build import build

    built = build(program, RunContext(), mocks)
    mocks.check_matches([*built.nodes, *mocks.replaced])
