"""Cuts what comes over a script port into programs."""

from __future__ import annotations

import re
from collections.abc import Iterator

from stretch_bt.hardware.emulators.tcp_server import is_web

__all__ = ["ScriptReader"]

_LONGEST = 1 << 20
_OPENS = re.compile(r"\s*(def|sec|thread|if|while|for)\b")
_CLOSES = re.compile(r"\s*end\s*(#.*)?$")


class ScriptReader:
    """A program is one line, or a block from `def` or `sec` to its `end`; empty lines and comments between them are left."""

    def __init__(self) -> None:
        self._rest = b""
        self._lines: list[str] = []
        self._depth = self._size = 0
        self._begun = False
        #: whether this is a request of HTTP, of which nothing is a program
        self.web = False

    def feed(self, data: bytes) -> Iterator[str]:
        """Yield the programs that are whole now; one of more than a MiB is given up with all that came before it."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        if self._size + len(self._rest) > _LONGEST:
            self._rest = b""
            self._forget()
            return
        for line in lines:
            self.web = self.web or (not self._begun and is_web(line))
            self._begun = True
            if self.web:
                return
            program = self._take(line.decode("utf-8", "replace").rstrip("\r"))
            if program is not None:
                yield program

    def _take(self, line: str) -> str | None:
        """Take a line, and return the program that it ends."""
        if not self._lines and not line.split("#", maxsplit=1)[0].strip():
            return None
        self._lines.append(line)
        self._size += len(line)
        if _OPENS.match(line):
            self._depth += 1
        elif _CLOSES.match(line):
            self._depth -= 1
        if self._depth > 0:
            return None
        program = "\n".join([*self._lines, ""])
        self._forget()
        return program

    def _forget(self) -> None:
        self._lines, self._depth, self._size = [], 0, 0
