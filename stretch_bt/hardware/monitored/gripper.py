"""The gripper as nodes see it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from stretch_bt.errors import InvalidInput, LimitExceeded
from stretch_bt.hardware.driver import GripperDriver
from stretch_bt.hardware.interfaces import Gripper, Motion, Reading
from stretch_bt.hardware.monitored.mover import Mover

__all__ = ["MonitoredGripper"]


class MonitoredGripper(Mover[GripperDriver]):
    """A gripper that stretches the membrane no further than the limits allow."""

    readings: ClassVar[Mapping[str, Any]] = Gripper.readings

    def move(self, opening: float, *, speed: float, owner: str) -> Motion:
        """Open or close to `opening`, m, at `speed`, m/s."""
        self.check_ready()
        if not math.isfinite(opening):
            raise InvalidInput(f"{self.name}: opening must be finite, m, not {opening}")
        limits = self.watch.limits
        try:
            limits.check_speed(self.name, speed, limits.gripper_speed)
            limits.check_opening(self.name, opening, self.watch.hand)
        except LimitExceeded as fault:
            raise self.refuse(fault) from None
        self.take_over()
        self.command("move", {"opening": opening, "speed": speed}, owner)
        with self.faults():
            poll = self.driver.move(opening, speed)
        return self.own(poll, owner)

    def activate(self, *, owner: str) -> Motion:
        """Make the gripper ready to move, on a person's word: its fingers may travel all their way, whatever the limits say."""
        self.check_ready()
        self.take_over()
        self.command("activate", {}, owner)
        with self.faults():
            poll = self.driver.activate()
        return self.own(poll, owner)

    def opening(self, max_age: float) -> Reading[float]:
        """Return the measured opening, m, at most `max_age` s old."""
        return self.read("opening", self.driver.opening, max_age)
