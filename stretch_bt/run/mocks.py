"""Mocks by path pattern: any node of an unedited tree is replaced, without a device or a scene.

A pattern is a path in which `*` stands for one segment and `**` for any number; `fit_sphere[1]` is the second of its
name in its place. A pattern that matches nothing is an error.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import py_trees
from py_trees.common import Status

from stretch_bt.errors import Diagnostic, FileError, MocksError, TreeError
from stretch_bt.hardware.interfaces import INTERFACES, readings_of
from stretch_bt.run.context import RunContext
from stretch_bt.run.mock_node import Mock, MockNode, iter_then, mock_value, pattern_fits
from stretch_bt.source import Map, Mark, Scalar, Seq, Value, closest, did_you_mean, load, unknown_key
from stretch_bt.tree.build import Builder, BuiltTree, build
from stretch_bt.tree.cell import Cell
from stretch_bt.tree.document import Document
from stretch_bt.tree.expression import ExpressionError, bind, parse, typecheck
from stretch_bt.tree.flow import Part
from stretch_bt.tree.program import Program, find_tree
from stretch_bt.tree.types import BOOL, INT, Type, from_annotation, quantity
from stretch_bt.tree.values import Refused, check_bounds, literal
from stretch_bt.units import KINDS

__all__ = ["FORMAT", "Expectation", "Mocks", "check_mocks", "read_mocks", "tree_of"]

FORMAT = "stretch-mocks/1"
TOP = ("format", "doc", "tree", "mocks", "readings", "expect")
FIELDS = ("match", "status", "status_when", "after", "outputs", "then", "message")
THEN = ("repeat_last", "cycle", "fail")
STATUSES = {"success": Status.SUCCESS, "failure": Status.FAILURE, "running": Status.RUNNING}
#: mocks, and patterns of `visited` and `never`, in a file; each is held against every path of the tree
MOST = 500
#: characters of a pattern
LONGEST = 1000
#: patterns without a node that get a suggestion, which takes longer than all the rest
SUGGESTED = 20
TIME = quantity(KINDS["Time"].dimension)


@dataclass(slots=True)
class Expectation:
    """What a mocks file says of the run: its result, what was visited, what never, and how many ticks at most."""

    result: str | None = None
    visited: list[tuple[str, str | None]] = field(default_factory=list)
    never: list[tuple[str, str | None]] = field(default_factory=list)
    marks: list[tuple[str, Mark]] = field(default_factory=list)  # of every pattern of `visited` and `never`
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
        self.reading_marks: dict[str, Mark] = {}
        self.expect = Expectation()
        self.diagnostics: list[Diagnostic] = []
        self.replaced: list[str] = []
        self.suggested = 0

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

    def check_matches(self, built: BuiltTree, program: Program) -> None:
        """Note every rule, expectation and reading that means nothing in the tree built with these mocks.

        Raises
        ------
        MocksError
            There are any, or mistakes that were found while the tree was built.
        """
        paths = [*built.nodes, *self.replaced]
        idle = [rule for rule in self.rules if rule.matched == 0]
        every = list(build(program, RunContext()).nodes) if idle else []
        for rule in self.rules:
            if rule.matched == 0:
                self._idle(rule, paths, every)
                continue
            for name in rule.outputs.keys() - rule.known_outputs:
                self._unknown_output(name, rule.output_marks[name], rule.pattern, sorted(rule.known_outputs))
        for pattern, mark in self.expect.marks:
            if not any(pattern_fits(pattern, path) for path in paths):
                self._unmatched(pattern, mark, paths)
        self._check_readings(program.document)
        if self.diagnostics:
            raise MocksError(list(dict.fromkeys(self.diagnostics)))

    def _idle(self, rule: Mock, paths: list[str], every: list[str]) -> None:
        if any(rule.fits(path) for path in self.replaced):
            message = f"every node that {rule.pattern!r} means is taken by a rule above it"
            self._error(rule.mark, "mock-unmatched", message, "move it up, or make the other pattern narrower")
        elif any(rule.fits(path) for path in every):
            message = f"every node that {rule.pattern!r} means lies inside one that is replaced"
            self._error(rule.mark, "mock-unmatched", message, "remove one of the two")
        else:
            self._unmatched(rule.pattern, rule.mark, paths)

    def _check_readings(self, document: Document) -> None:
        known = {f"{d.name}.{r}" for d in document.devices.values() for r in readings_of(d.interface)}
        for name, mark in self.reading_marks.items():
            if name not in known:
                hint = did_you_mean(name, known) or "the tree declares no device with readings"
                self._error(mark, "name-unknown", f"the tree has no reading {name!r}", hint)

    def _unmatched(self, pattern: str, mark: Mark, paths: list[str]) -> None:
        self.suggested += 1
        meant = _closest_path(pattern, paths) if self.suggested <= SUGGESTED else ""
        hint = meant or "`stretch-bt show TREE` lists the paths"
        self._error(mark, "mock-unmatched", f"pattern {pattern!r} matches no node", hint)

    def _error(self, mark: Mark, code: str, message: str, hint: str) -> None:
        self.diagnostics.append(mark.error(code, message, hint))

    def _unknown_output(self, name: str, mark: Mark, pattern: str, known: list[str]) -> None:
        hint = did_you_mean(name, known) or "the tree wires no output of it"
        self._error(mark, "port-unknown", f"{pattern!r} writes no output {name!r} in this tree", hint)

    def _output(self, rule: Mock, name: str, cell: Cell, type_: Type) -> tuple[Cell, list[Any]]:
        values = []
        for value in rule.outputs[name]:
            try:
                values.append(mock_value(value, type_, name))
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
        for key, given in value:
            if key.text not in known:
                self.error(key.mark, "key-unknown", f"{what} has no {key.text!r}", unknown_key(key, given, known))

    def items(self, value: Value | None, what: str) -> list[Value]:
        if value is None:
            return []
        if isinstance(value, Seq):
            if len(value.items) > MOST:
                self.error(
                    value.mark,
                    "value",
                    f"{what!r} has {len(value.items)} entries; {MOST} are read",
                    "use patterns with *",
                )
            return list(value.items[:MOST])
        self.error(value.mark, "type-mismatch", f"{what!r} takes a list", "begin each entry with '- '")
        return []

    def is_pattern(self, value: Value, text: str) -> bool:
        """Note a pattern that is empty or longer than any path."""
        if 0 < len(text) <= LONGEST:
            return True
        what = f"a pattern has at most {LONGEST} characters" if text else "a pattern is a path, and this one is empty"
        self.error(value.mark, "value", what, 'write a path such as "**/press"')
        return False

    def rule(self, value: Value) -> None:
        if not isinstance(value, Map):
            self.error(
                value.mark, "type-mismatch", "a mock is a mapping", "write '- {match: \"**/press\", status: success}'"
            )
            return
        self.known(value, FIELDS, "a mock")
        match = value.get("match")
        if match is None:
            if not any(closest(key.text, ("match",)) for key, _ in value):
                self.error(value.mark, "key-missing", "a mock needs 'match'", "add 'match: \"**/press\"'")
            return
        if not isinstance(match, Scalar) or not self.is_pattern(match, match.text):
            if not isinstance(match, Scalar):
                self.error(match.mark, "type-mismatch", "'match' takes one pattern", "write 'match: \"**/press\"'")
            return
        rule = Mock(match.text, match.mark, self.statuses(value.get("status")))
        when = value.get("status_when")
        rule.status_when = when if isinstance(when, Scalar) else None
        if when is not None and rule.status_when is None:
            self.error(when.mark, "type-mismatch", "'status_when' takes an expression", "write it as text, in quotes")
        if when is not None and "status" in value:
            mark = value.key("status_when").mark
            self.error(mark, "key-duplicate", "'status' and 'status_when' exclude each other", "keep one")
        self.options(rule, value)
        self.found.rules.append(rule)

    def options(self, rule: Mock, value: Map) -> None:
        after = value.get("after")
        if after is not None:
            rule.after = self.literal(after, TIME, "after", 0.0)
        rule.then = self.option(value.get("then"), THEN, "then", "repeat_last")
        message = value.get("message")
        if message is not None and not isinstance(message, Scalar):
            self.error(message.mark, "type-mismatch", "'message' takes text", "write it in quotes")
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

    def literal(self, value: Value, type_: Type, what: str, low: float) -> Any:
        """Return a number of the file that is at least `low`; `low` itself, with an error, when it is none."""
        try:
            found = literal(value, type_, what)
            check_bounds(found, type_, low, None, value.mark, what)
        except Refused as refused:
            self.found.diagnostics.append(refused.diagnostic)
            return low
        return found

    def statuses(self, value: Value | None) -> list[Status]:
        given = list(value.items) if isinstance(value, Seq) else [value]
        if not given and value is not None:
            self.error(value.mark, "empty", "'status' has no values", "write one of success, failure, running")
        return [STATUSES[self.option(item, tuple(STATUSES), "status", "success")] for item in given]

    def readings(self, value: Value | None) -> None:
        if value is not None and not isinstance(value, Map):
            self.error(value.mark, "type-mismatch", "'readings' takes a mapping", "write '{arm.force: 1 N}'")
        types = {n: from_annotation(a) for i in INTERFACES.values() for n, a in readings_of(i).items()}
        for key, given in value if isinstance(value, Map) else ():
            type_ = types.get(key.text.rpartition(".")[2])
            if type_ is None or "." not in key.text:
                hint = did_you_mean(key.text, ("arm.force", "arm.height", "gripper.opening"))
                self.error(key.mark, "name-unknown", f"{key.text!r} is not a reading", hint)
                continue
            values = given.items if isinstance(given, Seq) else (given,)
            if not values:
                self.error(given.mark, "empty", f"{key.text!r} has no values", "write at least one")
            try:
                self.found.readings[key.text] = [literal(v, type_, key.text) for v in values]
                self.found.reading_marks[key.text] = key.mark
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
                self.visit(item, getattr(wanted, name))
        ticks = value.get("ticks_max")
        if ticks is not None:
            wanted.ticks_max = self.literal(ticks, INT, "ticks_max", 1)

    def visit(self, item: Value, patterns: list[tuple[str, str | None]]) -> None:
        """Read `path` or `path#status`."""
        text = item.text if isinstance(item, Scalar) else ""
        pattern, has_status, status = text.partition("#")
        if not pattern:
            self.error(item.mark, "type-mismatch", "a visit is a path, or path#status", "write 'main/press#success'")
            return
        if not self.is_pattern(item, pattern):
            return
        if has_status:
            mark = item.mark.shifted(len(pattern) + 1 + (isinstance(item, Scalar) and item.quoted), len(status) or 1)
            self.option(Scalar(status, False, mark), (*STATUSES, "invalid"), "status", "")
        patterns.append((pattern, status or None))
        self.found.expect.marks.append((pattern, item.mark))


def _closest_path(pattern: str, paths: list[str]) -> str:
    """Return a hint with a pattern like the given one that means some node."""
    last = {path.rpartition("/")[2].partition("[")[0]: path for path in paths}
    head, _, tail = pattern.rpartition("/")
    guess = closest(tail, last)
    within = [path for path in paths if path.startswith(f"{head}/")]
    candidates = difflib.get_close_matches(pattern, within, n=1, cutoff=0.3)
    candidates += [f"{head}/{guess}"] if guess and head else []
    candidates += difflib.get_close_matches(pattern, paths, n=1, cutoff=0.3)
    candidates += [last[guess]] if guess else []
    found = next((c for c in candidates if any(pattern_fits(c, path) for path in paths)), None)
    return f"did you mean {found!r}?" if found else ""


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
    if "main" not in program.document.trees:
        assert mocks.tree is not None
        what = f"{mocks.tree.text!r} is a library for import: it has no tree 'main' to run"
        raise MocksError([mocks.tree.mark.error("tree-wrong", what, "name a tree that calls it")])
    mocks.check_matches(build(program, RunContext(), mocks), program)
