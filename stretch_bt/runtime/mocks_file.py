"""Reads a mocks file, and notes every mistake of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from py_trees.common import Status

from stretch_bt.errors import FileError, MocksError
from stretch_bt.hardware.interfaces import INTERFACES, readings_of
from stretch_bt.runtime.expectation import wanted_output
from stretch_bt.runtime.mock_arrays import MockArrays, names_array
from stretch_bt.runtime.mock_mapping import WrittenMocks
from stretch_bt.runtime.mock_node import Mock
from stretch_bt.runtime.mocks import Mocks
from stretch_bt.source import (
    Map,
    Mark,
    Scalar,
    Seq,
    Value,
    closest,
    did_you_mean,
    load,
    read_text,
    told,
    unknown_key,
)
from stretch_bt.tree.types import INT, Type, from_annotation, quantity
from stretch_bt.tree.values import ValueRefused, check_bounds, literal
from stretch_bt.units import KINDS

__all__ = ["FIELDS", "FORMAT", "STATUSES", "THEN", "TOP", "read_mocks"]

FORMAT = "stretch-mocks/1"
TOP = ("format", "doc", "tree", "mocks", "readings", "expect")
FIELDS = ("match", "status", "status_when", "after", "outputs", "then", "message")
EXPECT = ("result", "visited", "never", "outputs", "commands", "ticks_max")
THEN = ("repeat_last", "cycle", "fail")
_IN_MEMORY = Path("mocks")
STATUSES = {"success": Status.SUCCESS, "failure": Status.FAILURE, "running": Status.RUNNING}
#: mocks, and patterns of `visited` and `never`, in a file; each is held against every path of the tree
MOST = 500
#: characters of a pattern
LONGEST = 1000
TIME = quantity(KINDS["Time"].dimension)


def read_mocks(
    given: Path | str | Mapping[str, Any],
    *,
    recorded: bool = False,
    arrays: MockArrays | None = None,
    keep: bool = False,
) -> Mocks:
    """Read mocks: a file, or its content as text of several lines or in braces, or as a mapping; raises MocksError with every mistake.

    With `keep` the mistakes of a file whose tree is known are kept, for `check_matches` to raise together with its own.

    In a mapping `format` and `tree` may be left out, arrays may stand for lists and for the arrays of records, and records for their
    fields. Places of mistakes in it are places in its text in YAML, which a run records. `arrays` are the arrays of a record.
    """
    path, text = _IN_MEMORY, ""
    try:
        if isinstance(given, Mapping):
            written = WrittenMocks({"format": FORMAT, **given})
            text, arrays = written.text, MockArrays(Path(), written.arrays)
        elif isinstance(given, str) and ("\n" in given or given.lstrip().startswith("{")):
            text = given
        else:
            path = Path(given)
            text = read_text(path)
        root = load(path, text=text)
    except FileError as error:
        raise MocksError(error.diagnostics) from None
    reader = _Reader(root, path, text, needs_tree=not (recorded or isinstance(given, Mapping)))
    if arrays is not None:
        reader.found.arrays = arrays
    found = reader.read()
    if found.diagnostics and not (keep and reader.knows_tree()):
        raise MocksError(found.diagnostics)
    return found


class _Reader:
    def __init__(self, root: Map, path: Path, text: str, *, needs_tree: bool) -> None:
        tree = root.get("tree")
        self.root = root
        self.needs_tree = needs_tree
        self.found = Mocks(str(path), tree if isinstance(tree, Scalar) and tree.text else None, path, text)

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
        if self.found.tree is None and self.needs_tree:
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

    def knows_tree(self) -> bool:
        """Whether this is a mocks file whose tree, if it must name one, is named."""
        form = self.root.get("format")
        return isinstance(form, Scalar) and form.text == FORMAT and not (self.needs_tree and self.found.tree is None)

    def known(self, value: Map, known: tuple[str, ...], what: str) -> None:
        for key, given in value:
            if key.text not in known:
                self.error(
                    key.mark, "key-unknown", f"{what} has no {key.text!r}", unknown_key(key, given, known, value)
                )

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
        rule.status_is_list = isinstance(value.get("status"), Seq)
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
            rule.lists |= {key.text} if isinstance(given, Seq) else set()
            if not rule.outputs[key.text]:
                self.error(given.mark, "empty", f"{key.text!r} has no values", "write at least one")

    def option(self, value: Value | None, options: tuple[str, ...], what: str, default: str) -> str:
        if value is None:
            return default
        if isinstance(value, Scalar) and value.text in options:
            return value.text
        hint = did_you_mean(value.text if isinstance(value, Scalar) else "", options)
        self.error(value.mark, "option-unknown", f"{told(value)} is not a {what}", hint)
        return default

    def literal(self, value: Value, type_: Type, what: str, low: float) -> Any:
        """Return a number of the file that is at least `low`; `low` itself, with an error, when it is none."""
        try:
            found = literal(value, type_, what)
            check_bounds(found, type_, low, None, value.mark, what)
        except ValueRefused as refused:
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
                self.found.readings[key.text] = self.numbers(values, type_, key.text)
                self.found.reading_marks[key.text] = key.mark
            except ValueRefused as refused:
                self.found.diagnostics.append(refused.diagnostic)

    def numbers(self, values: Iterable[Value], type_: Type, what: str) -> list[float]:
        """Return the values of a reading, one after the other; an array stands for its entries."""
        found: list[float] = []
        for value in values:
            found += self.found.arrays.numbers(value, what) if names_array(value) else [literal(value, type_, what)]
        return found

    def expect(self, value: Value | None) -> None:
        if value is None:
            return
        if not isinstance(value, Map):
            self.error(value.mark, "type-mismatch", "'expect' takes a mapping", "write {result: success}")
            return
        self.known(value, EXPECT, "expect")
        wanted = self.found.expect
        if "result" in value:
            results = ("success", "failure", "error", "fault", "interrupted")
            wanted.result = self.option(value.get("result"), results, "result", "success")
        for name in ("visited", "never"):
            for item in self.items(value.get(name), name):
                self.visit(item, getattr(wanted, name))
        self.wanted_outputs(value.get("outputs"))
        for item in self.items(value.get("commands"), "commands"):
            self.command(item)
        ticks = value.get("ticks_max")
        if ticks is not None:
            wanted.ticks_max = self.literal(ticks, INT, "ticks_max", 1)

    def wanted_outputs(self, value: Value | None) -> None:
        if value is not None and not isinstance(value, Map):
            hint = "write '{stiffness: {value: 1 N/mm, within: 5 %}}'"
            self.error(value.mark, "type-mismatch", "'outputs' takes a mapping from outputs of the task", hint)
        for key, given in value if isinstance(value, Map) else ():
            try:
                self.found.expect.outputs.append(wanted_output(key, given))
            except ValueRefused as refused:
                self.found.diagnostics.append(refused.diagnostic)

    def command(self, item: Value) -> None:
        if not isinstance(item, Scalar) or "." not in item.text:
            self.error(item.mark, "type-mismatch", "a command is device.command", "write 'arm.move'")
            return
        self.found.expect.commands.append((item.text, item.mark))

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
