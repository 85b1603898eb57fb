"""Mocks by path pattern: any node of an unedited tree is replaced, without a device or a scene.

A pattern is a path in which `*` stands for one segment and `**` for any number; `fit_sphere[1]` is the second of its
name in its place. A pattern that matches nothing is an error.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import py_trees
from py_trees.common import Status

from stretch_bt.errors import Diagnostic, MocksError, TreeError
from stretch_bt.hardware.interfaces import readings_of
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.expectation import Expectation
from stretch_bt.runtime.mock_arrays import MockArrays, names_array
from stretch_bt.runtime.mock_node import Mock, MockNode, iter_then, pattern_fits
from stretch_bt.runtime.mock_value import check_entries, check_port, mock_value
from stretch_bt.source import Mark, Scalar, Value, closest, did_you_mean
from stretch_bt.tree.build import Builder, build
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.document import Document
from stretch_bt.tree.expression import ExpressionError, bind, parse, typecheck
from stretch_bt.tree.flow import Leaf, Part
from stretch_bt.tree.port_check import PortCheck
from stretch_bt.tree.program import Program, find_tree
from stretch_bt.tree.types import BOOL, Type
from stretch_bt.tree.values import ValueRefused

__all__ = ["Mocks", "check_mocks", "for_another", "tree_of"]

#: patterns without a node that get a suggestion, which takes longer than all the rest
SUGGESTED = 20


class Mocks:
    """A mocks file, as substitutes for a builder."""

    def __init__(self, file: str, tree: Scalar | None, path: Path, text: str) -> None:
        self.file = file
        self.tree = tree
        self.path = path
        self.text = text
        self.arrays = MockArrays(path.parent)
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
        checks = part.info.written() if isinstance(part, Leaf) else {}
        given = {n: self._output(rule, n, type_, checks.get(n)) for n, (_, type_) in sinks.items() if n in rule.outputs}
        outputs = [(sinks[name][0], values) for name, values in given.items()]
        limit = min((len(values) for name, values in given.items() if name in rule.lists or len(values) > 1), default=0)
        for name, (cell, _) in sinks.items():
            if name not in rule.outputs:
                cell.blocked = f"the mock of {path} gives no output {name!r}"
        return MockNode(path, rule, outputs, limit, builder.context, self._script(rule, builder))

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
        self._check_tree(program.document)
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
        self.diagnostics += self.expect.resolve(built, program.document)
        if self.diagnostics:
            found = dict.fromkeys(self.diagnostics)
            raise MocksError(sorted(found, key=lambda d: (d.file, d.line, d.column)))

    def _check_tree(self, document: Document) -> None:
        """Raise MocksError where no pattern means a node and the file is for another tree: that is one mistake, and not one a pattern."""
        if self.tree is None or not self.rules or self.replaced:
            return
        wanted, given = Path(self.tree.text).stem, Path(document.file).stem
        if wanted != given:
            message = f"these mocks are for the tree {wanted!r} and match no node of {given!r}"
            hint = f"give mocks for {given!r}, or run {wanted!r}"
            raise MocksError([self.tree.mark.error("mock-unmatched", message, hint)])

    def _idle(self, rule: Mock, paths: list[str], every: list[str]) -> None:
        above = self.rules[: self.rules.index(rule)]
        if any(other.pattern == rule.pattern for other in above):
            message = f"a rule above it has the same pattern, {rule.pattern!r}, and takes every node that it means"
            remedy = "remove one; for one call after another give a list, as in `status: [success, failure]`"
            self._error(rule.mark, "mock-unmatched", message, remedy)
        elif any(rule.fits(path) for path in self.replaced):
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

    def _output(self, rule: Mock, name: str, type_: Type, check: PortCheck | None) -> list[Any]:
        """Return what a rule writes to a port, held against what the node itself may write, where `check` says so."""
        found = []
        try:
            check_entries(rule.outputs[name], type_, name)
        except ValueRefused as refused:
            self.diagnostics.append(refused.diagnostic)
            return []
        for value in rule.outputs[name]:
            try:
                values = self._values(value, type_, name)
                if check is not None:
                    for given in values:
                        check_port(given, check, value, name)
            except ValueRefused as refused:
                self.diagnostics += [refused.diagnostic, *refused.others]
            else:
                found += values
        return found

    def _values(self, value: Value, type_: Type, name: str) -> list[Any]:
        """Return what one value of a file stands for: itself, or an entry or row of an array for each start."""
        one = type_.item or type_
        if not (one.is_number and names_array(value)):
            return [mock_value(value, type_, name, self.arrays)]
        if type_.item is None:
            return self.arrays.numbers(value, name)
        deep = self.arrays.read(value, None, name).ndim
        return self.arrays.numbers(value, name, 2) if deep > 1 else [self.arrays.numbers(value, name)]

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


def for_another(mocks: Mocks, program: Program) -> list[Diagnostic]:
    """Return a warning where a mocks file names another tree than the one that is run."""
    meant, run = mocks.tree, program.document.file
    if meant is None or not mocks.path.is_file() or Path(meant.text).stem == Path(run).stem:
        return []
    message = f"these mocks are for the tree {meant.text!r}, and this run is of {Path(run).name!r}"
    return [meant.mark.warning("tree-wrong", message, "run the tree that they are for, or correct 'tree:'")]


def check_mocks(mocks: Mocks, program: Program) -> None:
    """Build the program with the mocks, so that every pattern and output is matched; raises MocksError."""
    if "main" not in program.document.trees:
        assert mocks.tree is not None
        what = f"{mocks.tree.text!r} is a library for import: it has no tree 'main' to run"
        raise MocksError([mocks.tree.mark.error("tree-wrong", what, "name a tree that calls it")])
    mocks.check_matches(build(program, RunContext(), mocks), program)
