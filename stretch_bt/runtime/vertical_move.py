"""One motion of the hand straight up or down in the air, as a person asks for it."""

from __future__ import annotations

import math

from stretch_bt.clock import Clock
from stretch_bt.errors import DeviceFault, InvalidInput
from stretch_bt.frames import Wrench
from stretch_bt.hardware.ages import PLACE, UNHEARD
from stretch_bt.hardware.cell import Cell
from stretch_bt.hardware.cell_file import CellSpec
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.monitored.arm import MonitoredArm

__all__ = ["VerticalMove", "arm_of", "check_distance"]

_OWNER, _TICK = "move", 0.05
#: change of the force, N, at which the motion ends: more than noise and drift of a CB3's estimate once it is averaged
_FELT = 10.0
#: how far below the lowest place downwards a motion may end, m: the start is measured, not chosen
_ROUNDING = 0.001
#: how much longer than planned a motion may take, as a part and in s
_LONGER, _MORE = 2.0, 5.0


def arm_of(spec: CellSpec, device: str | None = None) -> str:
    """Return the name of a cell's arm; raises InvalidInput unless there is one of that name."""
    arms = [name for name, d in spec.devices.items() if d.type == "Arm"]
    if device is not None and device not in arms:
        raise InvalidInput(f"{device!r} is no arm of {spec.path.name}; {_named(arms)}")
    if device is None and len(arms) != 1:
        raise InvalidInput(f"{spec.path.name} has {len(arms)} arms, and one is moved; {_named(arms)}")
    return device or arms[0]


def _named(arms: list[str]) -> str:
    return f"name one with --device: {', '.join(arms)}" if arms else "it has none; add one to `devices`"


def check_distance(spec: CellSpec, by: float) -> None:
    """Raise InvalidInput for no distance, m, and for one down where the cell does not say where the hand may meet something."""
    if not (math.isfinite(by) and by != 0):
        raise InvalidInput("the distance is more than 0 mm, as in --up 10mm")
    if by < 0 and spec.limits.contact is None:
        raise InvalidInput(
            f"{spec.path.name} does not say where the hand may meet something, so it is not moved down; "
            "write 'limits: {contact: {below: ..., speed: ...}}'"
        )


class VerticalMove:
    """A motion by a distance, m, up or, below 0, down, at a speed, m/s; nothing moves before `go`.

    Downwards the hand goes no lower than where the cell says that it may meet something. The motion ends when the force changes by 10 N on
    the way, besides at the limits of the cell.

    Raises
    ------
    BeyondLimits
        The cell does not allow it.
    InvalidInput
        The hand may meet something on its way down.
    """

    def __init__(self, cell: Cell, name: str, by: float, speed: float) -> None:
        device = cell.devices[name]
        assert isinstance(device, MonitoredArm)
        self._arm, self._speed = device, speed
        self._start = device.pose(PLACE).value
        self._goal = self._start.moved(z=by)
        limits, height = cell.spec.limits, self._goal.height
        limits.check_way(name, speed, [self._start.height, height])
        limits.check_pose(name, self._goal, cell.hand)
        if by < 0 and limits.contact is not None and height < limits.contact.below - _ROUNDING:
            raise InvalidInput(
                f"--down ends at a height of {1e3 * height:.1f} mm, and below {1e3 * limits.contact.below:g} mm the hand may meet something; "
                "go less far"
            )

    def __str__(self) -> str:
        start, end = 1e3 * self._start.height, 1e3 * self._goal.height
        return (
            f"{self._arm.name}: the hand goes {'up' if end > start else 'down'} by {abs(end - start):g} mm at {1e3 * self._speed:g} mm/s, "
            f"from a height of {start:.1f} mm to {end:.1f} mm, in about {self._planned:.1f} s"
        )

    def go(self, clock: Clock) -> Finding:
        """Move, and return how it ended; raises DeviceFault."""
        before, begun, why = self._arm.wrench(UNHEARD).value, clock.now(), ""
        motion = self._arm.move(self._goal, speed=self._speed, owner=_OWNER)
        while (state := motion.poll()) is MotionState.MOVING and not why:
            clock.wait_until(clock.now() + _TICK)
            late = clock.now() - begun > _LONGER * self._planned + _MORE
            why = "it took much longer than planned" if late else self._obstacle(before)
        seconds = clock.now() - begun
        if why:
            return self.stopped(why)
        end = f"the hand stands at a height of {1e3 * self._height:.1f} mm, {self._gone}, after {seconds:.2f} s"
        well = state is MotionState.DONE
        return Finding(self._arm.name, well, end if well else f"the motion ended early ({state}): {end}")

    def stopped(self, why: str) -> Finding:
        """Stop the arm, and return where it stands."""
        try:
            self._arm.stop()
            return Finding(
                self._arm.name,
                False,
                f"{why}; the hand stands at a height of {1e3 * self._height:.1f} mm, {self._gone}",
            )
        except DeviceFault as fault:
            return Finding(self._arm.name, False, f"{why}; {fault}", "press the emergency stop where the arm moves")

    @property
    def _planned(self) -> float:
        return abs(self._goal.height - self._start.height) / self._speed

    @property
    def _height(self) -> float:
        return self._arm.pose(PLACE).value.height

    @property
    def _gone(self) -> str:
        gone = 1e3 * (self._height - self._start.height)
        return f"{abs(gone):.2f} mm {'higher' if gone >= 0 else 'lower'} than before"

    def _obstacle(self, before: Wrench) -> str:
        change = math.dist(self._arm.wrench(UNHEARD).value.force, before.force)
        return (
            f"the force changed by {change:.1f} N on the way, so that something holds the hand"
            if change > _FELT
            else ""
        )
