"""The arm as nodes see it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from stretch_bt.errors import DeviceFault, LimitExceeded, NoAnswer, StaleReading
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.ages import PLACE, UNHEARD
from stretch_bt.hardware.driver import ArmDriver
from stretch_bt.hardware.interfaces import Arm, Motion, Reading
from stretch_bt.hardware.latched import NEW_RUN
from stretch_bt.hardware.monitored.mover import Mover

__all__ = ["MonitoredArm"]

#: least time between two poses from which a speed is taken, s: a shorter one divides by noise
_APART = 0.01
#: largest distance of the hand from the end of a motion that is done, m: arms come within 0.1 mm, and report it a moment late
_OFF = 0.005


class MonitoredArm(Mover[ArmDriver]):
    """An arm that goes nowhere outside the limits, and stops when it feels more force than they allow, also where it stands.

    The speed is compared as it is asked for, and as it is measured from one poll to the next.
    """

    readings: ClassVar[Mapping[str, Any]] = Arm.readings
    _was_moved = False
    _before: Reading[Pose] | None = None
    #: whether the motion that goes on leads up from where it began
    _rises = False
    #: where the motion that goes on ends
    _goal: Pose | None = None

    def open(self) -> None:
        """Connect, free of an earlier fault; moves nothing."""
        self._was_moved = False
        super().open()

    def move(self, target: Pose, *, speed: float, owner: str) -> Motion:
        """Move in a straight line at `speed`, m/s."""
        return self._start("move", [target], {"target": target, "speed": speed}, owner)

    def follow(self, path: Sequence[Pose], *, speed: float, owner: str) -> Motion:
        """Move through the poses at `speed`, m/s, blending between them."""
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

    def force_noise(self) -> float:
        """Return the noise of the force, N s^0.5 an axis; one that there is is written down, because nodes decide by it."""
        with self.faults():
            noise = self.driver.force_noise()
        if noise > 0:
            now = self.watch.now()
            self.watch.journal.reading(self.name, "force_noise", Reading(noise, now, now, 0))
        return noise

    def guard(self) -> None:
        """Stop the arm, with a fault that stays, when it is too fast, feels more force than the cell allows, or feels nothing.

        Where a simulation has no force for a place, a motion that rises goes on: it leads away from what cannot be.
        """
        with self.faults():
            place = self.checked("pose", self.driver.pose())
        self._check_speed(place)
        try:
            with self.faults():
                reading = self.checked("wrench", self.driver.wrench())
        except NoAnswer:
            if self._rises:
                return
            raise
        if self.watch.now() - reading.host_time > UNHEARD:
            self.halt(StaleReading(self.name, f"the arm moved without a force reading for {UNHEARD} s"))
        if self.watch.now() - place.host_time > UNHEARD:
            self.halt(StaleReading(self.name, f"the arm moved without a new pose for {UNHEARD} s"))
        self._check_force(reading.value)

    def check_arrival(self) -> None:
        """Raise DeviceFault where the hand is far from the end of a motion that is said to be done: its base, or its driver, is wrong."""
        if self._goal is None:
            return
        off = math.dist(self.checked("pose", self.driver.pose()).value.position, self._goal.position)
        if off > _OFF:
            what = f"its driver says that the motion is done, and the hand is {1e3 * off:.1f} mm from its end"
            raise DeviceFault(
                self.name, f"{what}; mend the frame that its poses are in, or when the driver says so; then {NEW_RUN}"
            )

    def _check_speed(self, place: Reading[Pose]) -> None:
        """Compare the mean speed since the pose before with the limits."""
        before = self._before
        if before is None or (time := place.device_time - before.device_time) < _APART:
            return
        self._before = place
        speed = math.dist(place.value.position, before.value.position) / time
        try:
            self.watch.limits.check_measured(self.name, speed, [before.value.height, place.value.height])
        except LimitExceeded as fault:
            self.halt(fault)

    def _check_force(self, wrench: Wrench) -> None:
        try:
            self.watch.limits.check_force(self.name, wrench.magnitude)
        except LimitExceeded as fault:
            self.halt(fault)

    def _start(self, name: str, path: list[Pose], arguments: Mapping[str, Any], owner: str) -> Motion:
        self.check_command(owner, arguments)
        limits = self.watch.limits
        with self.faults():
            here, age = self.fresh("pose", self.driver.pose, PLACE)
        if age > PLACE:
            raise self.refuse(StaleReading(self.name, f"its latest pose is {age:.3g} s old, at most {PLACE} s to move"))
        try:
            limits.check_way(self.name, arguments["speed"], [pose.height for pose in (here.value, *path)])
            for pose in path:
                limits.check_pose(self.name, pose, self.watch.hand)
        except LimitExceeded as fault:
            raise self.refuse(fault) from None
        self.settle()
        self.command(name, arguments, owner)
        self._was_moved = True
        with self.faults():
            poll = self.driver.follow(path, arguments["speed"])
        # only now: a motion that goes on because this one was refused is watched as before
        self._before = here
        self._goal = path[-1] if path else None
        self._rises = min(pose.height for pose in path) > here.value.height
        return self.own(poll, owner)
