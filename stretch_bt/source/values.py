"""What a file is read into: scalars, sequences and mappings, each with its line and column."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from stretch_bt.errors import Diagnostic

__all__ = ["TRUTHS", "Map", "Mark", "Scalar", "Seq", "Value", "is_nothing", "is_null", "told"]

#: truths of YAML 1.1, which are text in YAML 1.2
TRUTHS = {
    **dict.fromkeys(("yes", "y", "on", "1", "true"), "true"),
    **dict.fromkeys(("no", "n", "off", "0", "false"), "false"),
}

_FEW = 8  # up to so many pairs are looked through; more have an index
_MAX_DIGITS = 18  # a longer whole number is read as a float, which no place for a whole number takes
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
        return Diagnostic(self.file, self.line, self.column, "error", code, _short(message), _short(hint), self.length)

    def warning(self, code: str, message: str, hint: str = "") -> Diagnostic:
        """Return a warning at this place."""
        return Diagnostic(
            self.file, self.line, self.column, "warning", code, _short(message), _short(hint), self.length
        )


def _short(text: str) -> str:
    """Return a text that quotes a file, without the middle where it would fill the screen."""
    return text if len(text) <= 500 else f"{text[:250]} ... {text[-200:]}"


@dataclass(frozen=True, slots=True)
class Scalar:
    """A single value: `text` as written, `value` by the YAML 1.2 core schema, and whether a comma comes next."""

    text: str
    quoted: bool
    mark: Mark
    comma: bool = field(default=False, compare=False)

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

    def _pair(self, key: str) -> tuple[Scalar, Value] | None:
        if len(self.pairs) > _FEW:
            return self._index.get(key)
        for pair in self.pairs:
            if pair[0].text == key:
                return pair
        return None

    def __contains__(self, key: str) -> bool:
        return self._pair(key) is not None

    def __iter__(self) -> Iterator[tuple[Scalar, Value]]:
        return iter(self.pairs)

    def get(self, key: str) -> Value | None:
        """Return the value of a key, or None."""
        pair = self._pair(key)
        return pair[1] if pair else None

    def key(self, key: str) -> Scalar:
        """Return the key itself, for its place."""
        pair = self._pair(key)
        if pair is None:
            raise KeyError(key)
        return pair[0]

    def plain(self) -> dict[str, Any]:
        """Return the values without their places."""
        return {key.text: value.plain() for key, value in self.pairs}


Value = Scalar | Seq | Map


def walk(value: Value) -> Iterator[tuple[Scalar | None, Value]]:
    """Yield a value and all that is in it, in the order of the file, each with its key where it stands in a mapping."""
    ahead: list[tuple[Scalar | None, Value]] = [(None, value)]
    while ahead:
        key, inner = ahead.pop()
        yield key, inner
        if isinstance(inner, Map):
            ahead.extend(reversed(inner.pairs))
        elif isinstance(inner, Seq):
            ahead.extend((None, item) for item in reversed(inner.items))


def is_nothing(value: Value) -> bool:
    """Whether nothing is written after a key, as after both in `{frame, contact}`; an explicit `null` is something."""
    return isinstance(value, Scalar) and not value.text and not value.quoted


def is_null(value: Value) -> bool:
    """Whether `null` or `~` is written."""
    return isinstance(value, Scalar) and bool(value.text) and value.value is None


def told(value: Value) -> str:
    """Return what a message calls a value: its text in quotes, `a list` or `a mapping`."""
    return repr(value.text) if isinstance(value, Scalar) else "a list" if isinstance(value, Seq) else "a mapping"


def _core_value(text: str) -> Any:
    if text in _WORDS:
        return _WORDS[text]
    if len(text) <= _MAX_DIGITS and _INT.fullmatch(text):
        return int(text, 0) if text[:2] in ("0o", "0x") else int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if text.lower() in (".inf", "+.inf", "-.inf"):
        return -math.inf if text[0] == "-" else math.inf
    return math.nan if text.lower() == ".nan" else text
