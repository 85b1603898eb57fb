"""A connection whose loss is told, and after which nothing moves until somebody acknowledges it."""

from __future__ import annotations

from stretch_bt.errors import DeviceLost, NotReady

__all__ = ["Latched"]


class Latched:
    """What stands of the connection to a device, which is `name` in messages."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._down: str | None = None
        self._untold: str | None = None
        self._unacknowledged: str | None = None

    def check_acknowledged(self) -> None:
        """Raise NotReady after a loss that nobody acknowledged."""
        if self._unacknowledged is not None:
            reason = (
                f"the connection broke ({self._unacknowledged}) and nobody acknowledged it; nothing moves until then"
            )
            raise NotReady(self.name, reason)

    def acknowledge(self) -> None:
        """Take a loss as known, so that commands are taken again; raises DeviceLost while the connection is down."""
        if self._down is not None:
            raise DeviceLost(self.name, f"the connection is still down ({self._down})")
        self._unacknowledged = self._untold = None

    def _latch(self, reason: str) -> None:
        """Write down a loss."""
        self._down = self._untold = self._unacknowledged = reason

    def _tell_loss(self) -> None:
        """Raise DeviceLost while the connection is down, and once after it was."""
        down, self._untold = self._down or self._untold, None
        if down is not None:
            raise DeviceLost(self.name, f"the connection broke ({down})")
