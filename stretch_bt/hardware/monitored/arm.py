"""The arm as nodes see it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from stretch_bt.errors import InvalidInput, LimitExceeded, StaleReading
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.driver import ArmDriver
from stretch_bt.hardware.interfaces import Arm, Motion, Reading
from stretch_bt.hardware.monitored.mover import Mover

__all__ = ["MonitoredArm"]

_FORCE_AGE = 0.5


class MonitoredArm(Mover[ArmDriver]):
    """An arm that goes nowhere outside the limits, and stops when it feels more force than they allow, also where it stands."""

    readings: ClassVar[Mapping[str, Any]] = Arm.readings
    _was_moved = False

    def move(self, target: Pose, *, speed: float, owner: str) -> Motion:
        """Move in a straight line at `speed`, m/s."""
        return self._start("move", [target], {"target": target, "speed": speed}, owner)

    def follow(self, path: Sequence[Pose], *, speed: float, owner: str) -> Motion:
        """Move through the poses at `speed`, m/s, blending between them."""
        if not path:
            raise InvalidInput(f"{self.name}: a path needs at least one pose")
        return self._start("follow", list(path), {"path": list(path), "speed": speed}, owner)

    def pose(self, max_age: float) -> Reading[Pose]:
        """Return the hand's pose, at most `max_age` s old; raises StaleReading."""
        return self.read("pose", self.driver.pose, max_age)

    def wrench(self, max_age: float) -> Reading[Wrench]:
        """Return the arm's own estimate of the contact wrench, at most `max_age` s old.

        Raises
        ------
        LimitExceeded
            Once: an arm that was moved feels more than the cell allows where it stands now, which is a fault that stays.
        """
        reading = self.read("wrench", self.driver.wrench, max_age)
        if self._was_moved and self.fault is None:
            self._check_force(reading.value)
        return reading

    def guard(self) -> None:
        """Stop the arm, with a fault that stays, when it feels more force than the cell allows, or feels nothing."""
        with self.faults():
            reading = self.driver.wrench()
        if self.watch.now() - reading.host_time > _FORCE_AGE:
            self.halt(StaleReading(self.name, f"the arm moved without a force reading for {_FORCE_AGE} s"))
        self._check_force(reading.value)

    def _check_force(self, wrench: Wrench) -> None:
        try:
            self.watch.limits.check_force(self.name, wrench.magnitude)
        except LimitExceeded as fault:
            self.halt(fault)

    def _start(self, name: str, path: list[Pose], arguments: Mapping[str, Any], owner: str) -> Motion:
        self.check_ready()
        limits = self.watch.limits
        try:
            limits.check_speed(self.name, arguments["speed"], limits.speed)
            for pose in path:
                limits.check_pose(self.name, pose, self.watch.hand)
        except LimitExceeded as fault:
            raise self.refuse(fault) from None
        self.take_over()
        self.command(name, arguments, owner)
        self._was_moved = True
        with self.faults():
            poll = self.driver.follow(path, arguments["speed"])
        return self.own(poll, owner)
