"""What a cell reports of its devices while it runs: the seam between devices and the record of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol

from stretch_bt.errors import DeviceFault, NoAnswer
from stretch_bt.hardware.interfaces import MotionState, Reading

__all__ = ["Journal", "Relay"]


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


class Relay:
    """A journal that passes everything on to those that listen at the moment, in their order."""

    def __init__(self, *listeners: Journal) -> None:
        self.listeners = list(listeners)

    @contextmanager
    def heard_by(self, journal: Journal) -> Iterator[None]:
        """Pass everything on to one journal more while the block runs."""
        self.listeners.append(journal)
        try:
            yield
        finally:
            self.listeners.remove(journal)

    def reading(self, device: str, name: str, reading: Reading[Any]) -> None:
        """A node was given this reading."""
        for listener in self.listeners:
            listener.reading(device, name, reading)

    def command(self, device: str, name: str, arguments: Mapping[str, Any], owner: str) -> None:
        """A node gave this command."""
        for listener in self.listeners:
            listener.command(device, name, arguments, owner)

    def motion(self, device: str, owner: str, state: MotionState) -> None:
        """A node polled a motion and was given this state."""
        for listener in self.listeners:
            listener.motion(device, owner, state)

    def fault(self, device: str, fault: DeviceFault) -> None:
        """A device fault reached a node."""
        for listener in self.listeners:
            listener.fault(device, fault)

    def unanswered(self, device: str, none: NoAnswer) -> None:
        """A device that is well had no answer for a node."""
        for listener in self.listeners:
            listener.unanswered(device, none)
