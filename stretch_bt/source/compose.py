"""From YAML events to values: anchors expanded by copying within a budget, duplicate keys and tags refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from typing import NoReturn

import yaml

from stretch_bt.errors import Diagnostic, FileError
from stretch_bt.source.syntax import explain_syntax, lines_of
from stretch_bt.source.values import Map, Mark, Scalar, Seq, Value, is_nothing

__all__ = ["parse", "refuse"]

MAX_NODES = 20_000
MAX_DEPTH = 150
_TOO_DEEP = f"nesting deeper than {MAX_DEPTH}, anchors expanded", "use subtrees"
#: libyaml's message about brackets that are deeper than its own bound of 1000
_DEPTH_OF_PARSER = "maximum nesting depth"

_COMMA = re.compile(r"[ \t]*,")
_LOADER = getattr(yaml, "CLoader", yaml.Loader)


@lru_cache(maxsize=8)  # a check reads a file for its format, and again for its content
def parse(text: str, file: str) -> Value:
    """Read YAML text; raises FileError with the place of the mistake."""
    try:
        return _Composer(text, file).document()
    except yaml.MarkedYAMLError as error:
        place, message, hint = explain_syntax(text, error)
        line, column = (place.line + 1, place.column + 1) if place else (1, 1)
        if _DEPTH_OF_PARSER in str(error):  # it counts brackets before it hands on the first of them
            refuse(file, "yaml-depth", *_TOO_DEEP, line, column)
        refuse(file, "yaml-syntax", message, hint, line, column)
    except (yaml.YAMLError, UnicodeEncodeError) as error:  # a character that YAML forbids
        position = _position(text, error)
        *above, last = lines_of(text[:position])
        message = f"this is not YAML: the character {text[position : position + 1]!r} is forbidden"
        refuse(file, "yaml-syntax", message, "remove the character", len(above) + 1, len(last) + 1)


def _position(text: str, error: Exception) -> int:
    """Return the number of characters before the one that YAML forbids."""
    if isinstance(error, UnicodeEncodeError):  # no text of a file has it, an argument may
        return error.start
    position: int = getattr(error, "position", 0)
    if _LOADER is yaml.Loader:
        return position
    return len(text.encode()[:position].decode(errors="ignore"))  # libyaml counts bytes


def refuse(file: str, code: str, message: str, hint: str, line: int = 1, column: int = 1) -> NoReturn:
    """Raise FileError with one error."""
    raise FileError([Diagnostic(file, line, column, "error", code, message, hint)])


class _Composer:
    """Builds values from YAML events, within limits, without recursion into the parser's own objects."""

    def __init__(self, text: str, file: str) -> None:
        self.text, self.file = text, file
        self.events = yaml.parse(text, Loader=_LOADER)
        #: by name: the value, how many values it holds, and how many levels
        self.anchors: dict[str, tuple[Value, int, int]] = {}
        self.count = 0
        self.deepest = 0

    def document(self) -> Value:
        found: Value | None = None
        for event in self.events:
            if isinstance(event, yaml.DocumentStartEvent):
                if found is not None:
                    self.refuse(event, "yaml-documents", "a second document begins here", "keep one document a file")
                found = self.value(next(self.events), 0)
        if found is None:
            refuse(self.file, "file-empty", "the file is empty", "begin with 'format: ...'")
        return found

    def refuse(self, event: yaml.Event, code: str, message: str, hint: str) -> NoReturn:
        mark = self.mark(event, 1)
        refuse(self.file, code, message, hint, mark.line, mark.column)

    def value(self, event: yaml.Event, depth: int) -> Value:
        self.spend(event, 1)
        self.descend(event, depth)
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event, depth)
        assert isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent)
        self.untagged(event)
        before, above, self.deepest = self.count, self.deepest, depth
        if isinstance(event, yaml.ScalarEvent):
            made: Value = self.scalar(event)
        elif isinstance(event, yaml.SequenceStartEvent):
            made = Seq(tuple(self.items(depth)), self.mark(event, 1))
        else:
            made = self.mapping(event, depth)
        if event.anchor is not None:
            self.anchors[event.anchor] = (made, self.count - before + 1, self.deepest - depth)
        self.deepest = max(above, self.deepest)
        return made

    def descend(self, event: yaml.Event, depth: int) -> None:
        """Note how deep the present value reaches."""
        if depth > MAX_DEPTH:
            self.refuse(event, "yaml-depth", *_TOO_DEEP)
        self.deepest = max(self.deepest, depth)

    def spend(self, event: yaml.Event, nodes: int) -> None:
        self.count += nodes
        if self.count > MAX_NODES:
            self.refuse(
                event,
                "yaml-size",
                f"more than {MAX_NODES} values, anchors expanded",
                "remove anchors, or split the file",
            )

    def alias(self, event: yaml.AliasEvent, depth: int) -> Value:
        if event.anchor not in self.anchors:
            self.refuse(event, "yaml-anchor", f"no anchor &{event.anchor} stands before this", "define it first")
        value, size, levels = self.anchors[event.anchor]
        self.spend(event, size)
        self.descend(event, depth + levels)
        return _copy(value)

    def items(self, depth: int) -> Iterator[Value]:
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            yield self.value(event, depth + 1)

    def mapping(self, event: yaml.Event, depth: int) -> Map:
        pairs: dict[str, tuple[Scalar, Value]] = {}
        while not isinstance(key_event := next(self.events), yaml.MappingEndEvent):
            if not isinstance(key_event, yaml.ScalarEvent):
                self.refuse(key_event, "yaml-key", "a key must be plain text", "put the value under a name")
            key = self.key(key_event)
            if key.text in pairs:
                first, before = pairs[key.text]
                again = self.value(next(self.events), depth + 1)
                cut = getattr(event, "flow_style", False) and (is_nothing(before) or is_nothing(again))
                comma = "; put quotes around an expression with a comma, which ends a value between braces"
                message = f"{key.text!r} stands twice (first on line {first.mark.line})"
                self.refuse(key_event, "yaml-duplicate", message, f"keep one{comma if cut else ''}")
            if key.text == "<<" and not key.quoted:
                self.refuse(key_event, "yaml-merge", "merge keys (<<) are not YAML 1.2", "write the values out")
            pairs[key.text] = (key, self.value(next(self.events), depth + 1))
        return Map(tuple(pairs.values()), self.mark(event, 1))

    def key(self, event: yaml.ScalarEvent) -> Scalar:
        self.untagged(event)
        if event.anchor is not None:
            self.refuse(event, "yaml-key", f"the anchor &{event.anchor} stands on a key", "put it before the value")
        return self.scalar(event)

    def untagged(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent) -> None:
        if event.tag is not None:
            self.refuse(event, "yaml-tag", f"tags such as {event.tag!r} have no meaning here", "remove the tag")

    def scalar(self, event: yaml.ScalarEvent) -> Scalar:
        start, end = event.start_mark, event.end_mark
        assert start is not None
        assert end is not None
        length = end.column - start.column if end.line == start.line else 1
        comma = _COMMA.match(self.text, end.index) is not None
        return Scalar(event.value, event.style not in (None, ""), self.mark(event, max(length, 1)), comma)

    def mark(self, event: yaml.Event, length: int) -> Mark:
        start = event.start_mark
        assert start is not None
        return Mark(self.file, start.line + 1, start.column + 1, length)


def _copy(value: Value) -> Value:
    if isinstance(value, Scalar):
        return Scalar(value.text, value.quoted, value.mark, value.comma)
    if isinstance(value, Seq):
        return Seq(tuple(_copy(item) for item in value.items), value.mark)
    return Map(tuple((key, _copy(item)) for key, item in value.pairs), value.mark)
