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

    A position is believed when fingers can have come there from the one before, or from the answer to the question before, as after a
    pause in which somebody else moved them. The first one of all is believed. Everything but the position is taken as it is.

    Parameters
    ----------
    wire
        What is asked.
    now
        The clock of the run, s.
    """

    def __init__(self, wire: GripperWire, now: Callable[[], float]) -> None:
        self.bare, self._now = wire, now
        self.exchanges = wire.exchanges
        #: a position, and when it was asked for, s
        self._believed: tuple[int, float] | None = None
        self.connect, self.close, self.go, self.hold = wire.connect, wire.close, wire.go, wire.hold
        self.reset, self.activate = wire.reset, wire.activate

    def read(self) -> Status:
        """Return the gripper's present status; raises WireError where its positions agree with nothing."""
        asked: list[tuple[int, float]] = []
        while len(asked) < _TRIES:
            time = self._now()
            status = self.bare.read()
            here = status.position, time
            before = (self._believed, *asked[-1:])
            if self._believed is None or any(one is not None and _reachable(one, here) for one in before):
                self._believed = here
                return status
            asked.append(here)
        raise WireError(f"its positions agree with nothing: {', '.join(str(position) for position, _ in asked)}")


def _reachable(one: tuple[int, float], other: tuple[int, float]) -> bool:
    """Return whether fingers can have come from one position to another, each with its time, s."""
    return abs(other[0] - one[0]) <= _NEAR + _FASTEST * max(other[1] - one[1], 0.0)
