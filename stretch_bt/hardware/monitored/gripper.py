"""The gripper as nodes see it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from stretch_bt.errors import LimitExceeded
from stretch_bt.hardware.driver import GripperDriver
from stretch_bt.hardware.interfaces import Gripper, Motion, Reading
from stretch_bt.hardware.monitored.mover import Mover
from stretch_bt.hardware.past_limits import outside_limits
from stretch_bt.hardware.slack import SLACK

__all__ = ["MonitoredGripper"]


class MonitoredGripper(Mover[GripperDriver]):
    """A gripper that stretches the membrane no further than the limits allow."""

    readings: ClassVar[Mapping[str, Any]] = Gripper.readings

    _allowed: float | None = None

    def move(self, opening: float, *, speed: float, owner: str) -> Motion:
        """Open or close to `opening`, m, at `speed`, m/s."""
        arguments = {"opening": opening, "speed": speed}
        self.check_command(owner, arguments)
        limits = self.watch.limits
        try:
            limits.check_fingers(self.name, speed)
            limits.check_opening(self.name, opening, self.watch.hand)
        except LimitExceeded as fault:
            raise self.refuse(fault) from None
        self.settle()
        self.command("move", arguments, owner)
        with self.faults():
            poll = self.driver.move(opening, speed)
            self._allowed = self._beyond() + SLACK
        return self.own(poll, owner)

    def guard(self) -> None:
        """Stop fingers that leave the limits on their way; those that begin outside may come back."""
        with self.faults():
            beyond = self._beyond()
        if self._allowed is not None and beyond > self._allowed:
            stretch = self.watch.hand.geometry.stretch(self.driver.opening().value)
            span = self.watch.limits.stretch
            past = outside_limits("measured stretch", stretch, span.min, span.max)
            why = "see what else commands the fingers, and move them back; the limits are `stretch` under `limits`"
            self.halt(LimitExceeded(self.name, f"{past}; {why} in the cell file"))

    def _beyond(self) -> float:
        """Return how far the measured opening is outside the limits, m; 0 inside."""
        reading = self.checked("opening", self.driver.opening())
        stretch, span = self.watch.hand.geometry.stretch(reading.value), self.watch.limits.stretch
        return max(span.min - stretch, stretch - span.max, 0.0)

    def activate(self, *, owner: str) -> Motion:
        """Make the gripper ready to move, on a person's word: its fingers may travel all their way, whatever the limits say."""
        self.check_command(owner)
        self.settle()
        self.command("activate", {}, owner)
        with self.faults():
            poll = self.driver.activate()
            self._allowed = None
        return self.own(poll, owner)

    def opening(self, max_age: float) -> Reading[float]:
        """Return the measured opening, m, at most `max_age` s old."""
        return self.read("opening", self.driver.opening, max_age)
