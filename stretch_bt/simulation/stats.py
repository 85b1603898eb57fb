"""The twin's work: how often each thing was solved or stepped, and how long it took."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["Stats"]


class Stats:
    """Counts and CPU seconds by name; work timed inside other work counts for itself alone."""

    def __init__(self) -> None:
        self.counts: dict[str, int] = defaultdict(int)
        self.seconds: dict[str, float] = defaultdict(float)
        self._inside = [0.0]

    @contextmanager
    def timed(self, name: str) -> Iterator[None]:
        """Count the work inside once, and its CPU time without the time of work that is timed inside it."""
        began = time.process_time()
        self._inside.append(0.0)
        try:
            yield
        finally:
            spent = time.process_time() - began
            self.counts[name] += 1
            self.seconds[name] += spent - self._inside.pop()
            self._inside[-1] += spent

    def to_json(self) -> list[dict[str, Any]]:
        """Return a row for each name, the dearest first."""
        names = sorted(self.counts, key=lambda name: -self.seconds[name])
        return [{"name": n, "count": self.counts[n], "cpu_seconds": self.seconds[n]} for n in names]
