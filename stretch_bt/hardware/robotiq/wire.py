"""What the gripper driver needs of a wire, whatever the protocol."""

from __future__ import annotations

from typing import Protocol

from stretch_bt.hardware.robotiq.registers import Status

__all__ = ["GripperWire"]


class GripperWire(Protocol):
    """A connection to a gripper; each exchange ends within its deadline, or raises OSError."""

    #: how many exchanges a `read` makes
    exchanges: int

    def connect(self) -> None:
        """Connect; moves nothing."""

    def close(self) -> None:
        """Disconnect; may be called more than once."""

    def read(self) -> Status:
        """Return the gripper's present status."""

    def go(self, position: int, speed: int, force: int) -> None:
        """Send the fingers to a count. An inactive gripper may begin to activate: ask `read` before."""

    def hold(self, status: Status) -> None:
        """End a motion where the fingers are; `status` is the latest, of a gripper that is active."""

    def reset(self) -> None:
        """Clear faults and activation; moves nothing."""

    def activate(self) -> None:
        """Begin the activation of a gripper that was reset: the fingers travel."""
