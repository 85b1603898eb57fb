"""URScript cut into words, each with its place."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from stretch_bt.errors import IllConditioned

__all__ = ["END_OF_LINE", "NAME", "NUMBER", "SIGN", "STRING", "ScriptFault", "Token", "tokens"]

NAME, NUMBER, STRING, SIGN, END_OF_LINE = "name", "number", "string", "sign", "end of line"
_TOKEN = re.compile(
    r"(?P<space>[ \t\r\f\v]+|\#[^\n]*)"
    r"|(?P<number>0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
    r"|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<string>\"[^\"\n]*\"|'[^'\n]*')"
    r"|(?P<sign>==|!=|<=|>=|[-+*/%<>=()\[\],:])"
    r"|(?P<line>\n)"
)


class ScriptFault(IllConditioned):
    """What is wrong with a program, and where in it: line and column from 1."""

    def __init__(self, reason: str, line: int, column: int = 1) -> None:
        super().__init__(f"line {line}: {reason}")
        self.text, self.line, self.column = reason, line, column


class Token(NamedTuple):
    """A word: its kind, its text and where it begins."""

    kind: str
    text: str
    line: int
    column: int


def tokens(text: str) -> Iterator[Token]:
    """Yield the words of a program, the ends of its lines among them except in brackets; raises ScriptFault."""
    at = begin = depth = 0
    line = 1
    while at < len(text):
        found = _TOKEN.match(text, at)
        if found is None:
            raise ScriptFault(f"syntax_error_on_line:{line}:{text[at]}", line, at - begin + 1)
        kind, word = found.lastgroup or "", found.group()
        depth += (word in ("(", "[")) - (word in (")", "]"))
        if kind == "line":
            if depth <= 0:
                yield Token(END_OF_LINE, word, line, at - begin + 1)
            line, begin = line + 1, found.end()
        elif kind != "space":
            yield Token(kind, word, line, at - begin + 1)
        at = found.end()
    yield Token(END_OF_LINE, "", line, at - begin + 1)
