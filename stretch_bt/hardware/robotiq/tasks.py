"""What the gripper is doing: a journey of the fingers, or an activation, judged on each status that comes in."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

from stretch_bt.errors import DeviceFault
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.robotiq.calibration import GripperCalibration
from stretch_bt.hardware.robotiq.registers import PASSING, ActivationStage, ObjectStatus, Status, fault_of
from stretch_bt.hardware.robotiq.wire import GripperWire

__all__ = ["Activation", "GripperTask", "Journey", "fault_in", "lost_activation"]

#: how long the fingers may stand still, s, while they are commanded to move
PATIENCE = 0.8
_ACTIVATION = 15.0


def fault_in(device: str, status: Status) -> DeviceFault | None:
    """Return the fault that a status reports, if any."""
    if not status.fault:
        return None
    fault = fault_of(status.fault)
    return DeviceFault(device, f"fault {status.fault:02X}: {fault.means}; {fault.remedy}")


def lost_activation(device: str) -> DeviceFault:
    """Return the fault of a gripper that was active and is not any more."""
    reason = (
        "it lost its activation: it was reset, lost its supply, or somebody else uses it; "
        "activate it again with: stretch-bt activate CELL"
    )
    return DeviceFault(device, reason)


class GripperTask(ABC):
    """What was asked for; `after` is called in the thread that has the wire, with each new status."""

    def __init__(self) -> None:
        self.state = MotionState.MOVING
        self.fault: DeviceFault | None = None

    def poll(self) -> MotionState:
        """Return how it stands; raises the fault that ended it."""
        if self.fault is not None:
            raise self.fault
        return self.state

    @property
    def over(self) -> bool:
        """Whether nothing more is to be done for it."""
        return self.fault is not None or self.state is not MotionState.MOVING

    @abstractmethod
    def begin(self, wire: GripperWire) -> None:
        """Send what comes first."""

    @abstractmethod
    def after(self, wire: GripperWire, status: Status, now: float) -> None:
        """Take note of a status that was asked for at a time, s, and send what is next."""


@dataclass(frozen=True)
class Target:
    """Where the fingers are to go: opening, m, and count; from where, at which speed, m/s."""

    opening: float
    count: int
    start: float
    speed: float
    #: counts of the gripper's speed and force registers
    registers: tuple[int, int]
    #: whether the gripper cannot go so slowly, so that it is led there count by count
    led: bool


class Journey(GripperTask):
    """Fingers on their way to an opening.

    The gripper's word that it arrived is not enough: the membrane pulls the fingers shut, so the measured position decides. Where the
    wanted speed is below the slowest of the gripper, it is sent from count to count at that pace.
    """

    def __init__(
        self, device: str, target: Target, now: float, calibration: GripperCalibration, tolerance: float
    ) -> None:
        super().__init__()
        self._device, self._target, self._tolerance = device, target, tolerance
        self._opening, self._count = calibration.opening, calibration.nearest
        self._began = self._progress = now
        self._sent: int | None = None
        self._position: int | None = None

    def begin(self, wire: GripperWire) -> None:
        """Send the first count."""
        self._send(wire, self._due(self._began))

    def after(self, wire: GripperWire, status: Status, now: float) -> None:
        """Judge a status, and lead the fingers on."""
        heard = status.going and status.echo == self._sent
        self.fault = self._failed(status, heard)
        if self.fault is not None:
            return
        if status.position != self._position:
            self._position, self._progress = status.position, max(now, self._progress)
        if heard and status.found is not ObjectStatus.MOVING:
            self._arrived(status)
        if self._target.led and self._sent is not None and abs(status.position - self._sent) <= 1:
            self._progress = now  # they wait for the next count
        if self.state is MotionState.BLOCKED:
            wire.hold(status)  # else they would go on, and nobody looks, once nothing is in their way
        if self.over:
            return
        due = self._due(now)
        if now - self._progress > PATIENCE:
            self.fault = self._stuck(status, heard)
        elif due != self._sent:
            self._send(wire, due)

    def _failed(self, status: Status, heard: bool) -> DeviceFault | None:
        """Return what keeps the gripper from the motion; what its command clears counts once that is heard."""
        if status.fault in PASSING and not heard:
            return None
        return fault_in(self._device, status) or (None if status.ready else lost_activation(self._device))

    def _arrived(self, status: Status) -> None:
        near = abs(self._opening(status.position) - self._target.opening) <= self._tolerance
        met = status.found in (ObjectStatus.WHILE_OPENING, ObjectStatus.WHILE_CLOSING)
        if self._sent == self._target.count:
            self.state = MotionState.DONE if near else MotionState.BLOCKED
        elif met:
            self.state = MotionState.BLOCKED

    def _stuck(self, status: Status, heard: bool) -> DeviceFault:
        here, there = (f"{v * 1e3:.1f} mm" for v in (self._opening(status.position), self._target.opening))
        why = "the fingers do not move" if heard else "it does not follow its command"
        return DeviceFault(
            self._device,
            f"{why}: they stand at {here} on the way to {there}; look at gripper and membrane, then start a new run",
        )

    def _due(self, now: float) -> int:
        """Return the count that the fingers should be sent to by now."""
        target = self._target
        if not target.led:
            return target.count
        way = target.opening - target.start
        gone = target.speed * (now - self._began) + target.speed * 0.05
        return target.count if gone >= abs(way) else self._count(target.start + math.copysign(gone, way))

    def _send(self, wire: GripperWire, count: int) -> None:
        wire.go(count, *self._target.registers)
        self._sent = count


class Activation(GripperTask):
    """A reset, then the activation, in which the fingers travel all their way."""

    def __init__(self, device: str, now: float) -> None:
        super().__init__()
        self._device = device
        self._began = now
        self._activated = False

    def begin(self, wire: GripperWire) -> None:
        """Reset the gripper."""
        wire.reset()

    def after(self, wire: GripperWire, status: Status, now: float) -> None:
        """Go on to the activation once the reset is confirmed."""
        if not self._activated:
            if status.stage is ActivationStage.RESET and not status.activated:
                wire.activate()
                self._activated = True
        elif status.fault:
            self.fault = fault_in(self._device, status)
        elif status.ready:
            self.state = MotionState.DONE
        if not self.over and now - self._began > _ACTIVATION:
            reason = f"the activation did not end within {_ACTIVATION:.0f} s; look whether the fingers are free, then start a new run"
            self.fault = DeviceFault(self._device, reason)
