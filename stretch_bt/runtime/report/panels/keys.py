"""The keys that panels read of a record: the one place that compares the names of keys."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from stretch_bt.plain_numbers import is_number

__all__ = ["Key", "finite"]

Event = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Key:
    """A key that a panel reads: all of its name or the last part, the shipped trees that write it, and the fields that are read of a record."""

    name: str
    trees: tuple[str, ...]
    fields: tuple[str, ...] = ()

    def names(self, key: str) -> bool:
        """Return whether a key of a run is this one."""
        return f"/{key}".endswith(f"/{self.name}")

    def wrote(self, event: Event) -> bool:
        """Return whether an event wrote this key."""
        return event["type"] == "write" and self.names(str(event["key"]))

    def last(self, events: Iterable[Event]) -> Any:
        """Return the value that was written last; None where none was."""
        found = None
        for event in events:
            if self.wrote(event):
                found = event["value"]
        return found


def finite(value: Any) -> float | None:
    """Return a number as it is, None where a value is no number or not finite."""
    return float(value) if is_number(value) else None
