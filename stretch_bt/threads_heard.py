"""What breaks in threads of own code, which nobody waits for: told in the result of the run instead of as a raw traceback."""

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
    """What broke in threads: one line each, and where."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.broken: list[Broken] = []

    def __call__(self, told: Any) -> None:
        """Take what a thread raised; as ever, one that exits says nothing."""
        if told.exc_type is SystemExit or told.exc_value is None:
            return
        found = blame(told.exc_value)
        at = f" at {found['at']}" if found is not None else ""
        name = told.thread.name if told.thread is not None else "unknown"
        self.lines.append(f"thread {name!r} broke ({named(told.exc_value)}){at}")
        if found is not None:
            self.broken.append(found)

    def take(self) -> tuple[list[str], list[Broken]]:
        """Return what nobody has taken yet."""
        taken = self.lines, self.broken
        self.lines, self.broken = [], []
        return taken


@contextmanager
def threads_heard() -> Iterator[Heard]:
    """Hear what breaks in threads while the block runs; what nobody takes is said on standard error, a line each.

    Within another such block that one goes on hearing.
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
