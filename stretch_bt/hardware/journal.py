"""What a cell tells of its devices while it runs: the seam between devices and the record of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from stretch_bt.errors import DeviceFault, NoAnswer
from stretch_bt.hardware.interfaces import MotionState, Reading

__all__ = ["Journal", "NoJournal"]


class Journal(Protocol):
    """Takes note of everything that passes between nodes and devices."""

    def reading(self, device: str, name: str, reading: Reading[Any]) -> None:
        """A node was given this reading."""
        ...

    def command(self, device: str, name: str, arguments: Mapping[str, Any], owner: str) -> None:
        """A node gave this command."""
        ...

    def motion(self, device: str, owner: str, state: MotionState) -> None:
        """A node polled a motion and was given this state."""
        ...

    def fault(self, device: str, fault: DeviceFault) -> None:
        """A device fault reached a node."""
        ...

    def unanswered(self, device: str, none: NoAnswer) -> None:
        """A device that is well had no answer for a node."""
        ...


class NoJournal:
    """Takes no note."""

    def reading(self, device: str, name: str, reading: Reading[Any]) -> None:
        """Ignore it."""

    def command(self, device: str, name: str, arguments: Mapping[str, Any], owner: str) -> None:
        """Ignore it."""

    def motion(self, device: str, owner: str, state: MotionState) -> None:
        """Ignore it."""

    def fault(self, device: str, fault: DeviceFault) -> None:
        """Ignore it."""

    def unanswered(self, device: str, none: NoAnswer) -> None:
        """Ignore it."""
