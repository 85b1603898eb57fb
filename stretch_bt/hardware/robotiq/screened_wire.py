"""A wire whose positions are believed only where fingers can be: one that jumps has to be confirmed."""

from __future__ import annotations

from collections.abc import Callable

from stretch_bt.hardware.robotiq.registers import Status
from stretch_bt.hardware.robotiq.wire import GripperWire
from stretch_bt.hardware.wire_thread import WireError

__all__ = ["ScreenedWire"]

#: how far a position may be from the one before without any time in between, counts
_NEAR = 8
#: counts that fingers can pass in a second, and more: a 2F-140 needs 0.56 s for all its way at full speed
_FASTEST = 700.0
#: how often a gripper is asked in a row before its positions count as broken
_TRIES = 4


class ScreenedWire:
    """Asks once more after a position that the fingers cannot have reached since the one before.

    A position is believed when it is near the one before, or near the answer to the question before, as after a pause in which
    somebody else moved the fingers. Everything but the position is taken as it is.

    Parameters
    ----------
    wire
        What is asked.
    now
        The clock of the run, s.
    """

    def __init__(self, wire: GripperWire, now: Callable[[], float]) -> None:
        self.bare, self._now = wire, now
        self._believed: tuple[int, float] | None = None
        self.connect, self.close, self.go, self.hold = wire.connect, wire.close, wire.go, wire.hold
        self.reset, self.activate = wire.reset, wire.activate

    def read(self) -> Status:
        """Return what the gripper tells now; raises WireError where its positions agree with nothing."""
        asked: list[int] = []
        while len(asked) < _TRIES:
            time = self._now()
            status = self.bare.read()
            if self._reachable(status.position, time) or (asked and abs(status.position - asked[-1]) <= _NEAR):
                self._believed = status.position, time
                return status
            asked.append(status.position)
        raise WireError(f"its positions agree with nothing: {', '.join(map(str, asked))}")

    def _reachable(self, position: int, time: float) -> bool:
        if self._believed is None:
            return False
        before, since = self._believed
        return abs(position - before) <= _NEAR + _FASTEST * max(time - since, 0.0)
