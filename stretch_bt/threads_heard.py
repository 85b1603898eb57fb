"""Errors in threads of the user's own code, which nobody waits for: they stand in the result of the run, not in a raw traceback."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from stretch_bt.blame import Broken, blame
from stretch_bt.errors import named

__all__ = ["Heard", "threads_heard"]


class Heard:
    """Errors in threads: one line each, and the place."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.broken: list[Broken] = []

    def __call__(self, told: Any) -> None:
        """Take the error that a thread raised; as ever, a thread that exits says nothing."""
        if told.exc_type is SystemExit or told.exc_value is None:
            return
        found = blame(told.exc_value)
        at = f" at {found['at']}" if found is not None else ""
        name = told.thread.name if told.thread is not None else "unknown"
        self.lines.append(f"thread {name!r} broke ({named(told.exc_value)}){at}")
        if found is not None:
            self.broken.append(found)

    def take(self) -> tuple[list[str], list[Broken]]:
        """Return the errors that nobody has taken yet."""
        taken = self.lines, self.broken
        self.lines, self.broken = [], []
        return taken


@contextmanager
def threads_heard() -> Iterator[Heard]:
    """Collect errors in threads while the block runs; those that nobody takes are written to standard error, a line each.

    Within another such block, the outer one goes on noting them.
    """
    before = threading.excepthook
    if isinstance(before, Heard):
        yield before
        return
    threading.excepthook = heard = Heard()
    try:
        yield heard
    finally:
        threading.excepthook = before
        for line in heard.take()[0]:
            sys.stderr.write(f"{line}\n")
