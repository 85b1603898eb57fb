"""Whoever follows a run, and how it is kept from holding up the safe end of one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from stretch_bt.errors import writable

__all__ = ["Careful", "Watcher"]


class Watcher(Protocol):
    """Whoever follows a run: the record, and the live view."""

    def begin_tick(self, tick: int, time: float) -> None:
        """A tick begins."""
        ...

    def status(self, path: str, status: str, reason: str = "") -> None:
        """A node changed its status."""
        ...

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """A node wrote a key; `value` is None where it left the key without one."""
        ...

    def note(self, kind: str, **fields: Any) -> None:
        """Anything else."""
        ...


class Careful:
    """Passes everything on; an error goes to `errors` instead of the caller."""

    def __init__(self, watcher: Watcher, errors: list[str]) -> None:
        self.watcher = watcher
        self.errors = errors

    def begin_tick(self, tick: int, time: float) -> None:
        """A tick begins."""
        self._try(lambda: self.watcher.begin_tick(tick, time))

    def status(self, path: str, status: str, reason: str = "") -> None:
        """A node changed its status."""
        self._try(lambda: self.watcher.status(path, status, reason))

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """A node wrote a key; `value` is None where it left the key without one."""
        self._try(lambda: self.watcher.write(key, value, sd, path))

    def note(self, kind: str, **fields: Any) -> None:
        """Anything else."""
        self._try(lambda: self.watcher.note(kind, **fields))

    def _try(self, action: Callable[[], None]) -> None:
        try:
            action()
        except Exception as error:
            text = f"{type(self.watcher).__name__}: {writable(error)}"
            if text not in self.errors:
                self.errors.append(text)
