"""What an engine runs, and what comes back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

__all__ = ["Job", "Ran"]


@dataclass(frozen=True, slots=True)
class Ran:
    """What came of an item: its row, the files of its record where one is kept, and whether a signal to its process ended it."""

    row: dict[str, Any]
    record: Mapping[str, bytes] | None = None
    stopped: bool = False


class Job(Protocol):
    """What an engine runs: something that a process elsewhere can run, known by its key, which is also the key of its row."""

    @property
    def key(self) -> str:
        """Text that distinguishes it from all others."""
        ...

    def run(self) -> Ran:
        """Run it here, and return what came of it."""
        ...

    def killed(self) -> Ran:
        """Return what is known where its process died of it."""
        ...
