"""Whoever follows a run without taking part: does nothing until it overrides something."""

from __future__ import annotations

from collections import deque
from typing import Any

__all__ = ["Onlooker", "Visits"]

#: texts that a result keeps, the latest ones: a run may take days
LOGGED = 10_000


class Onlooker:
    """A watcher that ignores everything."""

    def begin_tick(self, tick: int, time: float) -> None:
        """A tick begins, at `time`, s."""

    def status(self, path: str, status: str, reason: str = "") -> None:
        """A node came to another status."""

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """A node wrote a key; `value` is None where it left the key without one."""

    def note(self, kind: str, **fields: Any) -> None:
        """Anything else happened."""


class Visits(Onlooker):
    """Notes which node came to which status, each once, in the order in which they came, and what was logged of late."""

    def __init__(self) -> None:
        self.statuses: dict[str, dict[str, None]] = {}
        self.logged: deque[tuple[str, str]] = deque(maxlen=LOGGED)

    @property
    def seen(self) -> set[tuple[str, str]]:
        """The visits as (path, STATUS)."""
        return {(path, status) for path, found in self.statuses.items() for status in found}

    def status(self, path: str, status: str, reason: str = "") -> None:
        """Note it."""
        self.statuses.setdefault(path, {})[status] = None
        if path.rpartition("/")[2].partition("[")[0].endswith(":log") and status in ("SUCCESS", "FAILURE"):
            self.logged.append((path, reason))
