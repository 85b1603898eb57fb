"""A connection whose loss stays."""

from __future__ import annotations

from collections.abc import Callable

from stretch_bt.errors import DeviceLost

__all__ = ["NEW_RUN", "Latched"]

#: what a person does after a fault was dealt with; a device in fault takes no commands until then
NEW_RUN = "start a new run"


class Latched:
    """What is known of the connection to a device.

    Parameters
    ----------
    name
        The device, for messages.
    remark
        Returns what is said besides of a loss, or nothing.
    """

    def __init__(self, name: str, remark: Callable[[], str] = lambda: "") -> None:
        self.name = name
        self._remark = remark
        self._lost: str | None = None

    def check_connected(self) -> None:
        """Raise DeviceLost once the connection was lost."""
        if self._lost is not None:
            said = (f"the connection broke ({self._lost})", self._remark(), NEW_RUN)
            raise DeviceLost(self.name, "; ".join(filter(None, said)))

    def _latch(self, reason: str) -> None:
        """Write down a loss; the first one stays."""
        self._lost = self._lost or reason
