"""How a 2F gripper behaves behind its registers, from the manual: activation, echo, finite speed, objects, faults.

Assumed, because the manual does not say: a fault of silence (09) ends with the next write; during activation the fingers open,
close and open again at 100 mm/s; the hand accelerates them at 2 m/s²; without communication they go on to where they were sent.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from stretch_bt.hardware.emulators.faults import Fault
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.robotiq.registers import ActivationStage, Command, ObjectStatus, Status, fault_of

__all__ = ["GRIPPER_FAULTS", "GripperModel"]

#: counts at the ends of the fingers, and the openings there, m, of a 2F-140
_OPEN, _CLOSED = 3, 230
_WIDE = 0.140
_SLOWEST, _FASTEST = 0.030, 0.250
_ACTIVATING = 0.100
_SILENT = 1.0
_TOUCH = 1e-6

GRIPPER_FAULTS: dict[str, Fault] = {
    "code": Fault(
        "shows the fault code `code` until the gripper is reset, or for 08 until it is cleared",
        {"code": 0x0C},
        state=True,
        bounds={"code": (0, 0x0F)},
    ),
    "deactivate": Fault("loses its activation, as after a loss of its supply; once", state=True),
    "object": Fault("has an object between the fingers, `opening` metres wide", {"opening": 0.05}, state=True),
    "stall": Fault("the fingers stand, and it goes on to say that they move", state=True),
    "wild": Fault("reports a random position in the part `part` of its answers", {"part": 0.1}, state=True),
    "deaf": Fault("confirms what is written, and does nothing of it", state=True),
}


class GripperModel:
    """The gripper of a stage; not safe to share without a lock.

    Parameters
    ----------
    stage
        What has the fingers.
    shown
        Returns the parameters of an active fault, or None.
    """

    def __init__(self, stage: StandInWorld, shown: Callable[[str], dict[str, float] | None]) -> None:
        self._stage, self._shown = stage, shown
        self._random = np.random.default_rng(0)
        self._command = Command(activate=False)
        self._stage_of = ActivationStage.RESET
        self._fault = 0
        self._arrival = -math.inf
        self._goal: float | None = None
        self._pace = _SLOWEST
        self._met = ObjectStatus.ARRIVED
        self._plan: list[float] = []
        self._heard = time.monotonic()
        self.writes = 0
        self._seen: frozenset[str] = frozenset()

    def activated(self) -> None:
        """Stand as after an activation, with the fingers where they are."""
        self._command = Command(activate=True)
        self._stage_of = ActivationStage.ACTIVE

    @property
    def command(self) -> Command:
        """The last command that it received."""
        return self._command

    def read(self) -> Status:
        """Return the status."""
        self._notice()
        self._go_on()
        self._listen()
        opening = self._stage.opening()
        return Status(
            activated=self._command.activate,
            going=self._command.go,
            stage=self._stage_of,
            found=self._found(),
            fault=self._fault,
            echo=self._command.position,
            position=self._told(count_of(opening)),
            current=10 if self._moving() else 0,
        )

    def write(self, command: Command) -> None:
        """Take a command."""
        self._notice()
        self._go_on()
        self._listen()
        if self._shown("deaf") is not None:
            return
        self.writes += 1
        if self._fault in (0x05, 0x07, 0x09):
            self._fault = 0
        before, self._command = self._command, command
        if not command.activate:
            self._reset()
        elif not before.activate and not command.release:
            self._activate()
        elif self._stage_of is ActivationStage.ACTIVATING:
            self._fault = 0x05 if command.go else self._fault
        elif self._fault == 0:
            self._obey(command)

    def changed(self) -> None:
        """Take note of a fault that began or ended."""
        self._seen = self._states()
        code = self._shown("code")
        if code is not None:
            self._fault = int(code["code"])
            self._halt()
            if fault_of(self._fault).reset:
                self._stage_of = ActivationStage.RESET
        elif self._fault == 0x08:
            self._fault = 0
        if self._shown("stall") is not None:
            self._stage.stop_fingers()
        elif self._goal is not None and self._moving():
            self._drive(self._goal, self._pace)

    def _states(self) -> frozenset[str]:
        return frozenset(name for name in GRIPPER_FAULTS if self._shown(name) is not None)

    def _notice(self) -> None:
        """See whether the time of a fault has passed."""
        if self._states() < self._seen:
            self.changed()

    def lose_activation(self) -> None:
        """Stand as after a loss of the supply."""
        self._command = Command(activate=False)
        self._reset()

    def state(self) -> dict[str, Any]:
        """Return how the fingers stand."""
        self._notice()
        self._go_on()
        return {"opening": self._stage.opening(), "writes": self.writes, "moving": self._moving(), "fault": self._fault}

    def _reset(self) -> None:
        self._halt()
        self._command = replace(self._command, go=False)
        self._stage_of, self._plan = ActivationStage.RESET, []
        if self._fault != 0x08:
            self._fault = 0

    def _activate(self) -> None:
        self._stage_of = ActivationStage.ACTIVATING
        self._plan = [_WIDE, 0.0, _WIDE]
        self._drive(self._plan.pop(0), _ACTIVATING)

    def _obey(self, command: Command) -> None:
        if command.release:
            self._fault = 0x0B
            self._drive(_WIDE if command.release_opens else 0.0, _SLOWEST)
        elif self._stage_of is not ActivationStage.ACTIVE:
            self._fault = 0x07 if command.go else self._fault
        elif command.go:
            self._drive(opening_of(command.position), self._speed())
        else:
            self._halt()

    def _go_on(self) -> None:
        """Do what is next once the fingers have arrived."""
        while self._goal is not None and self._stage.now() >= self._arrival and self._shown("stall") is None:
            self._goal = None
            if self._plan:
                self._drive(self._plan.pop(0), _ACTIVATING)
            elif self._stage_of is ActivationStage.ACTIVATING:
                blocked = self._met is not ObjectStatus.ARRIVED
                self._stage_of = ActivationStage.RESET if blocked else ActivationStage.ACTIVE
                self._fault = 0x0D if blocked else self._fault
                if self._command.go and not blocked:
                    self._obey(self._command)
            elif self._fault == 0x0B:
                self._fault = 0x0F

    def _drive(self, goal: float, speed: float) -> None:
        """Send the fingers to an opening, m, or to the object that is in the way."""
        here = self._stage.opening()
        goal = min(max(goal, opening_of(_CLOSED)), opening_of(_OPEN))
        self._met = ObjectStatus.ARRIVED
        thing = self._shown("object")
        reached = goal
        if thing is not None:
            width = thing["opening"]
            if goal < width - _TOUCH <= here:
                reached, self._met = width, ObjectStatus.WHILE_CLOSING
            elif here <= width + _TOUCH < goal:
                reached, self._met = width, ObjectStatus.WHILE_OPENING
        self._goal, self._pace = goal, speed
        self._arrival = self._stage.move_fingers(reached, speed)
        if self._shown("stall") is not None:
            self._stage.stop_fingers()

    def _halt(self) -> None:
        if self._moving():
            self._stage.stop_fingers()
        self._goal, self._plan = None, []

    def _moving(self) -> bool:
        return self._goal is not None

    def _told(self, position: int) -> int:
        wild = self._shown("wild")
        return (
            int(self._random.integers(256)) if wild is not None and self._random.random() < wild["part"] else position
        )

    def _found(self) -> ObjectStatus:
        return ObjectStatus.MOVING if self._moving() else self._met

    def _speed(self) -> float:
        return _SLOWEST + self._command.speed / 255 * (_FASTEST - _SLOWEST)

    def _listen(self) -> None:
        """Notice that nothing was heard for a second; that is counted by the machine's clock."""
        now = time.monotonic()
        if now - self._heard > _SILENT and self._command.activate and self._fault == 0:
            self._fault = 0x09
        self._heard = now


def opening_of(count: float) -> float:
    """Return the opening at a count, m."""
    return _WIDE * (_CLOSED - count) / (_CLOSED - _OPEN)


def count_of(opening: float) -> int:
    """Return the count at an opening, m."""
    return round(_CLOSED - opening / _WIDE * (_CLOSED - _OPEN))
