"""Text files with positions: YAML 1.2 core values, duplicate keys refused, every value knows its line and column.

A file is read into `Scalar`, `Seq` and `Map` values; `validate` fits one to a pydantic model and reports every mistake at
once, at its place, with a suggestion. Anchors are expanded by copying, within a budget, so no two places share an object.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import yaml

from stretch_bt.errors import Diagnostic, FileError

__all__ = [
    "Map",
    "Mark",
    "Scalar",
    "Seq",
    "Value",
    "closest",
    "did_you_mean",
    "load",
    "parse",
    "read_text",
    "resolve",
    "validate",
]

MAX_BYTES = 1_000_000
MAX_NODES = 50_000
MAX_DEPTH = 150

_LOADER = getattr(yaml, "CLoader", yaml.Loader)
_INT = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_WORDS: dict[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}


@dataclass(frozen=True, slots=True)
class Mark:
    """A place in a file; line and column count from 1, `length` is how many characters to underline."""

    file: str
    line: int
    column: int
    length: int = 1

    def shifted(self, offset: int, length: int = 1) -> Mark:
        """Return the place `offset` characters further on the same line."""
        return Mark(self.file, self.line, self.column + offset, length)

    def error(self, code: str, message: str, hint: str = "") -> Diagnostic:
        """Return an error at this place."""
        return Diagnostic(self.file, self.line, self.column, "error", code, message, hint, self.length)

    def warning(self, code: str, message: str, hint: str = "") -> Diagnostic:
        """Return a warning at this place."""
        return Diagnostic(self.file, self.line, self.column, "warning", code, message, hint, self.length)


@dataclass(frozen=True, slots=True)
class Scalar:
    """A single value: `text` as written, `value` by the YAML 1.2 core schema."""

    text: str
    quoted: bool
    mark: Mark

    @property
    def value(self) -> Any:
        """None, bool, int, float or str."""
        return self.text if self.quoted else _core_value(self.text)

    def plain(self) -> Any:
        """Return the value without its place."""
        return self.value


@dataclass(frozen=True, slots=True)
class Seq:
    """A list of values."""

    items: tuple[Value, ...]
    mark: Mark

    def plain(self) -> list[Any]:
        """Return the values without their places."""
        return [item.plain() for item in self.items]


@dataclass(frozen=True)
class Map:
    """A mapping from text keys to values, in the order of the file."""

    pairs: tuple[tuple[Scalar, Value], ...]
    mark: Mark

    @cached_property
    def _index(self) -> dict[str, tuple[Scalar, Value]]:
        return {key.text: (key, value) for key, value in self.pairs}

    def __contains__(self, key: str) -> bool:
        return key in self._index

    def __iter__(self) -> Iterator[tuple[Scalar, Value]]:
        return iter(self.pairs)

    def get(self, key: str) -> Value | None:
        """Return the value of a key, or None."""
        entry = self._index.get(key)
        return entry[1] if entry else None

    def key(self, key: str) -> Scalar:
        """Return the key itself, for its place."""
        return self._index[key][0]

    def plain(self) -> dict[str, Any]:
        """Return the values without their places."""
        return {key.text: value.plain() for key, value in self.pairs}


Value = Scalar | Seq | Map


def _core_value(text: str) -> Any:
    if text in _WORDS:
        return _WORDS[text]
    if _INT.fullmatch(text):
        return int(text, 0) if text[:2] in ("0o", "0x") else int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if text.lower() in (".inf", "+.inf", "-.inf"):
        return -math.inf if text[0] == "-" else math.inf
    return math.nan if text.lower() == ".nan" else text


def closest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that is most like this one, or None."""
    known = list(known)
    folded = {k.lower(): k for k in known}
    match = difflib.get_close_matches(word.lower(), folded, n=1, cutoff=0.6)
    return folded[match[0]] if match else None


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return a suggestion: the closest known word, or all of them when few, or nothing."""
    known = sorted(known)
    match = closest(word, known)
    if match is not None:
        return f"did you mean {match!r}?"
    return f"known here: {', '.join(known)}" if 0 < len(known) <= 24 else ""


def _refuse(file: str, code: str, message: str, hint: str, line: int = 1, column: int = 1) -> NoReturn:
    raise FileError([Diagnostic(file, line, column, "error", code, message, hint)])


def read_text(path: Path, name: str | None = None) -> str:
    """Return the text of a file, or raise FileError that says why it cannot be one."""
    file = name or str(path)
    try:
        if path.is_dir():
            _refuse(file, "file-folder", "this is a folder, not a file", "name the YAML file in it")
        if path.stat().st_size > MAX_BYTES:
            _refuse(file, "file-size", f"the file is over {MAX_BYTES // 1_000_000} MB", "split it, and use imports")
        data = path.read_bytes()
    except FileNotFoundError:
        _refuse(file, "file-missing", "no such file", "check the path")
    except (OSError, ValueError) as error:
        _refuse(file, "file-unreadable", f"the file cannot be read ({error})", "check its permissions")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        _refuse(file, "file-binary", f"byte {error.start} is not UTF-8 text", "save the file as UTF-8 text", line)
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        _refuse(file, "file-binary", "the file holds NUL bytes, so it is not text", "name a YAML file", line)
    return text


def resolve(given: str | Path, shipped: Path, kind: str) -> Path:
    """Return the file that a path, or the name of a shipped file of this kind, stands for; raises FileError."""
    path = Path(given)
    found = shipped / f"{given}.yaml"
    if path.suffix in (".yaml", ".yml") or len(path.parts) != 1 or path.is_file():
        return path
    if not found.is_file():
        if path.exists():
            return path
        hint = did_you_mean(str(given), (p.stem for p in shipped.glob("*.yaml")))
        _refuse(str(given), f"{kind}-unknown", f"there is no shipped {kind} and no file of this name", hint)
    return found


def load(path: Path, name: str | None = None) -> Map:
    """Read a file whose top level is a mapping; `name` is what messages call it."""
    file = name or str(path)
    value = parse(read_text(path, file), file)
    if not isinstance(value, Map):
        raise FileError([value.mark.error("yaml-top", "the top level is not a mapping", "begin with 'format: ...'")])
    return value


def parse(text: str, file: str) -> Value:
    """Read YAML text; raises FileError with the place of the mistake."""
    try:
        return _Composer(text, file).document()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        problem = " ".join(part for part in (error.context, error.problem) if part)
        _refuse(file, "yaml-syntax", f"this is not YAML: {problem}", _syntax_hint(text, line), line, column)
    except yaml.YAMLError as error:  # a character that YAML forbids
        position = getattr(error, "position", 0)
        line = text.count("\n", 0, position) + 1
        _refuse(file, "yaml-syntax", f"this is not YAML: {error}".splitlines()[0], "remove the character", line)


def _syntax_hint(text: str, line: int) -> str:
    lines = text.splitlines()
    before = lines[max(line - 2, 0) : line]
    if any("\t" in row[: len(row) - len(row.lstrip())] for row in before):
        return "indent with spaces, not tabs"
    if any(re.search(r":\s+[*&!|>%@`]", row) for row in before):
        return "put quotes around text that begins with a special character"
    return "check indentation, brackets and quotes on this line and the one before"


class _Composer:
    """Builds values from YAML events, within limits, without recursion into the parser's own objects."""

    def __init__(self, text: str, file: str) -> None:
        self.file = file
        self.events = yaml.parse(text, Loader=_LOADER)
        self.anchors: dict[str, tuple[Value, int]] = {}
        self.count = 0

    def document(self) -> Value:
        found: Value | None = None
        for event in self.events:
            if isinstance(event, yaml.DocumentStartEvent):
                if found is not None:
                    self.refuse(event, "yaml-documents", "a second document begins here", "keep one document a file")
                found = self.value(next(self.events), 0)
        if found is None:
            _refuse(self.file, "file-empty", "the file is empty", "begin with 'format: ...'")
        return found

    def refuse(self, event: yaml.Event, code: str, message: str, hint: str) -> NoReturn:
        mark = event.start_mark
        _refuse(self.file, code, message, hint, mark.line + 1, mark.column + 1)

    def value(self, event: yaml.Event, depth: int) -> Value:
        self.spend(event, 1)
        if depth > MAX_DEPTH:
            self.refuse(event, "yaml-depth", f"nesting deeper than {MAX_DEPTH}", "use subtrees")
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event)
        before = self.count
        if isinstance(event, yaml.ScalarEvent):
            made: Value = self.scalar(event)
        elif isinstance(event, yaml.SequenceStartEvent):
            made = Seq(tuple(self.items(depth)), self.mark(event, 1))
        else:
            made = self.mapping(event, depth)
        if event.anchor is not None:
            self.anchors[event.anchor] = (made, self.count - before + 1)
        return made

    def spend(self, event: yaml.Event, nodes: int) -> None:
        self.count += nodes
        if self.count > MAX_NODES:
            self.refuse(
                event,
                "yaml-size",
                f"more than {MAX_NODES} values, anchors expanded",
                "remove anchors, or split the file",
            )

    def alias(self, event: yaml.AliasEvent) -> Value:
        if event.anchor not in self.anchors:
            self.refuse(event, "yaml-anchor", f"no anchor &{event.anchor} stands before this", "define it first")
        value, size = self.anchors[event.anchor]
        self.spend(event, size)
        return _copy(value)

    def items(self, depth: int) -> Iterator[Value]:
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            yield self.value(event, depth + 1)

    def mapping(self, event: yaml.Event, depth: int) -> Map:
        pairs: dict[str, tuple[Scalar, Value]] = {}
        while not isinstance(key_event := next(self.events), yaml.MappingEndEvent):
            if not isinstance(key_event, yaml.ScalarEvent):
                self.refuse(key_event, "yaml-key", "a key must be plain text", "put the value under a name")
            key = self.scalar(key_event)
            if key.text in pairs:
                first = pairs[key.text][0].mark.line
                self.refuse(
                    key_event, "yaml-duplicate", f"{key.text!r} stands twice (first on line {first})", "keep one"
                )
            if key.text == "<<" and not key.quoted:
                self.refuse(key_event, "yaml-merge", "merge keys (<<) are not YAML 1.2", "write the values out")
            pairs[key.text] = (key, self.value(next(self.events), depth + 1))
        return Map(tuple(pairs.values()), self.mark(event, 1))

    def scalar(self, event: yaml.ScalarEvent) -> Scalar:
        quoted = event.style not in (None, "")
        end = event.end_mark
        one_line = end.line == event.start_mark.line
        length = end.column - event.start_mark.column if one_line else 1
        return Scalar(event.value, quoted, self.mark(event, max(length, 1)))

    def mark(self, event: yaml.Event, length: int) -> Mark:
        return Mark(self.file, event.start_mark.line + 1, event.start_mark.column + 1, length)


def _copy(value: Value) -> Value:
    if isinstance(value, Scalar):
        return Scalar(value.text, value.quoted, value.mark)
    if isinstance(value, Seq):
        return Seq(tuple(_copy(item) for item in value.items), value.mark)
    return Map(tuple((key, _copy(item)) for key, item in value.pairs), value.mark)


M = TypeVar("M")


def validate(model: type[M], value: Value) -> M:
    """Fit a value to a pydantic model; raises FileError with every mistake at its place."""
    from pydantic import TypeAdapter, ValidationError

    try:
        return TypeAdapter(model).validate_python(value.plain())
    except ValidationError as error:
        raise FileError([_explain(model, value, e) for e in error.errors(include_url=False)]) from None


def _explain(model: type, root: Value, error: Any) -> Diagnostic:
    """Turn one pydantic error into a diagnostic at the place it speaks of."""
    value, path = _locate(root, error["loc"])
    where = ".".join(path)
    kind = error["type"]
    if kind == "extra_forbidden":
        parent, _ = _locate(root, error["loc"][:-1])
        key = str(error["loc"][-1])
        mark = parent.key(key).mark if isinstance(parent, Map) and key in parent else value.mark
        return mark.error(
            "key-unknown", f"unknown key {key!r}", did_you_mean(key, _field_names(model, error["loc"][:-1]))
        )
    if kind == "missing":
        return value.mark.error("key-missing", f"{where} is missing", f"add '{error['loc'][-1]}: ...'")
    message = error["msg"].removeprefix("Value error, ")
    message, _, hint = message.partition("; ")
    return value.mark.error("value", f"{where}: {message}", hint or _expectation(error))


def _expectation(error: Any) -> str:
    expected = error.get("ctx", {}).get("expected")
    given = error.get("input")
    if expected and isinstance(given, str):
        options = re.findall(r"'([^']*)'", expected)
        return did_you_mean(given, options)
    return f"expected {expected}" if expected else "see the schema of this file"


def _locate(root: Value, loc: Sequence[str | int]) -> tuple[Value, list[str]]:
    """Follow a pydantic location as far as the file goes; tags of unions are passed over."""
    value, path = root, []
    for step in loc:
        if isinstance(value, Map) and str(step) in value:
            value = value.get(str(step)) or value
            path.append(str(step))
        elif isinstance(value, Seq) and isinstance(step, int) and step < len(value.items):
            value = value.items[step]
            path.append(str(step))
        elif step is loc[-1] and isinstance(value, Map):
            path.append(str(step))
    return value, path


def _field_names(model: Any, loc: Sequence[str | int]) -> list[str]:
    """Return every field name reachable under a location, by the model's JSON schema."""
    from pydantic import TypeAdapter

    schema = TypeAdapter(model).json_schema()
    definitions = schema.get("$defs", {})
    nodes = [schema]
    for step in loc:
        nodes = [n for node in nodes for n in _children(node, step, definitions)]
    return sorted({name for node in nodes for n in _variants(node, definitions) for name in n.get("properties", {})})


def _variants(node: dict[str, Any], definitions: dict[str, Any]) -> list[dict[str, Any]]:
    if "$ref" in node:
        return _variants(definitions[node["$ref"].rpartition("/")[2]], definitions)
    options = node.get("anyOf", []) + node.get("oneOf", [])
    return [v for option in options for v in _variants(option, definitions)] or [node]


def _children(node: dict[str, Any], step: str | int, definitions: dict[str, Any]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for variant in _variants(node, definitions):
        properties = variant.get("properties", {})
        if str(step) in properties:
            found.append(properties[str(step)])
        elif isinstance(step, int) and "items" in variant:
            found.append(variant["items"])
        elif isinstance(variant.get("additionalProperties"), dict):
            found.append(variant["additionalProperties"])
        else:  # the tag of a union
            found.append(variant)
    return found
