"""Devices that say what a record says, and note the commands that they get."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from stretch_bt.errors import BeyondLimits, DeviceFault, LimitExceeded, NoAnswer, NotReady, StaleReading
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.asked import check_age, check_asked
from stretch_bt.hardware.interfaces import DeviceState, Motion, MotionState, Reading
from stretch_bt.hardware.journal import Journal
from stretch_bt.hardware.owner import check_owner
from stretch_bt.runtime.replay.log import Diverged, Log

__all__ = ["ReplayedCell"]


class _ReplayedMotion:
    """A motion whose states come from the record."""

    def __init__(self, device: _ReplayedDevice, owner: str) -> None:
        self.owner = owner
        self.device = device
        self.ended = False

    def poll(self) -> MotionState:
        """Return the recorded state."""
        state: MotionState = self.device.take("motion", self.owner)
        self.device.journal.motion(self.device.name, self.owner, state)
        self.ended = self.ended or state is not MotionState.MOVING
        return state

    def stop(self) -> None:
        """Note the stop when the motion still has the device."""
        if not self.ended:
            self.ended = True
            self.device.journal.command(self.device.name, "stop", {}, self.owner)
            self.device.raise_due()


class _ReplayedDevice:
    """Any device: readings and motions by name, commands noted."""

    def __init__(self, name: str, log: Log, journal: Journal) -> None:
        self.name = name
        self.log = log
        self.journal = journal
        self.current: _ReplayedMotion | None = None
        self.faulty = False
        self.latched = False

    @property
    def state(self) -> DeviceState:
        """Where the device stood: it was open throughout the run."""
        return DeviceState.FAULT if self.latched else DeviceState.READY

    def take(self, kind: str, name: str) -> Any:
        """Return the next recorded value, or raise the recorded fault or NoAnswer."""
        item = self.log.peek(self.name)
        if (
            kind == "motion"
            and item is not None
            and item.kind == "unanswered"
            and self.log.moves_after(self.name, name)
        ):
            # of the force, for which a motion that rises does not wait
            self.journal.unanswered(self.name, self.log.take_next(self.name))
        try:
            return self.log.next(self.name, kind, name)
        except DeviceFault as fault:
            self.suffer(fault, halted=kind == "motion" and isinstance(fault, LimitExceeded | StaleReading))
            raise
        except NoAnswer as none:
            self.journal.unanswered(self.name, none)
            raise

    def suffer(self, fault: DeviceFault, *, halted: bool = False) -> None:
        """Note a fault; one that the cell found while it looked at a motion had `halted` it."""
        self.faulty = True
        self.latched = self.latched or halted or not isinstance(fault, StaleReading | LimitExceeded | NotReady)
        self.journal.fault(self.name, fault)
        if halted:
            self.stop()

    def raise_due(self) -> None:
        """Raise the fault that the record has next, if it has one."""
        if self.log.due_fault(self.name) is not None:
            fault = self.log.take_next(self.name)
            self.suffer(fault)
            raise fault

    def read(self, name: str, max_age: float = math.inf) -> Reading[Any]:
        """Return the next recorded reading; an age that the run refused is refused."""
        if max_age != math.inf:
            check_age(self.name, max_age)
        reading: Reading[Any] = self.take("reading", name)
        self.journal.reading(self.name, name, reading)
        return reading

    def command(self, name: str, arguments: Mapping[str, Any], owner: str) -> Motion:
        """Note a command and return its motion, or raise the fault with which it was refused."""
        due = self.log.due_fault(self.name)
        nearer = isinstance(due, BeyondLimits) and self.log.moves_after(self.name, owner)  # tried once this was refused
        if due is not None and (nearer or not self.log.commanded(self.name, owner)):
            refused = self.log.take_next(self.name)
            self.journal.fault(self.name, refused)
            raise refused
        check_owner(self.name, owner)
        check_asked(self.name, arguments)
        self.stop()
        self.journal.command(self.name, name, arguments, owner)
        fault = self.log.due_fault(self.name)
        # a motion that began and was lost gets a stop command; a command that the device did not take is no motion
        of_later = isinstance(fault, LimitExceeded | StaleReading) or self.log.commanded(self.name, owner, "stop")
        if fault is not None and not of_later:
            self.raise_due()
        self.current = _ReplayedMotion(self, owner)
        return self.current

    def release(self, owner: str) -> None:
        """Stop the motion that an owner left under way, as the device of the run did."""
        motion = self.current
        if self.faulty or motion is None or motion.owner != owner or motion.ended:
            return
        try:
            moves = motion.poll() is MotionState.MOVING
        except NoAnswer:
            moves = True
        if moves:
            motion.stop()

    def stop(self) -> None:
        """End the present motion without a word, as a device that is stopped or taken over."""
        if self.current is not None:
            self.current.ended = True


class _ReplayedArm(_ReplayedDevice):
    def move(self, target: Pose, *, speed: float, owner: str) -> Motion:
        return self.command("move", {"target": target, "speed": speed}, owner)

    def follow(self, path: Sequence[Pose], *, speed: float, owner: str) -> Motion:
        return self.command("follow", {"path": list(path), "speed": speed}, owner)

    def pose(self, max_age: float) -> Reading[Pose]:
        return self.read("pose", max_age)

    def wrench(self, max_age: float) -> Reading[Wrench]:
        reading: Reading[Wrench] = self.read("wrench", max_age)
        fault = self.log.due_fault(self.name)
        moved = self.current is not None  # an arm that was not moved yet may feel whatever it feels
        if moved and isinstance(fault, LimitExceeded) and _is_of(fault, reading.value):
            self.suffer(self.log.take_next(self.name), halted=True)
            raise fault
        return reading

    def force_noise(self) -> float:
        item = self.log.peek(self.name)
        return float(self.read("force_noise").value) if item is not None and item.name == "force_noise" else 0.0


class _ReplayedGripper(_ReplayedDevice):
    def move(self, opening: float, *, speed: float, owner: str) -> Motion:
        return self.command("move", {"opening": opening, "speed": speed}, owner)

    def activate(self, *, owner: str) -> Motion:
        return self.command("activate", {}, owner)

    def opening(self, max_age: float) -> Reading[float]:
        return self.read("opening", max_age)


class _ReplayedCamera(_ReplayedDevice):
    @property
    def intrinsics(self) -> Intrinsics:
        found = self.log.reader.intrinsics(self.name)
        if found is None:
            raise Diverged(
                f"{self.name}: the tree asks for its intrinsics, and the record holds no frame that has them"
            )
        return found

    def frame(self, max_age: float) -> Reading[DepthFrame]:
        return self.read("frame", max_age)

    @property
    def ended(self) -> bool:
        item = self.log.peek(self.name)
        return item is not None and item.name == "ended" and bool(self.read("ended").value)


class _ReplayedForceSensor(_ReplayedDevice):
    def wrench(self, max_age: float) -> Reading[Wrench]:
        return self.read("wrench", max_age)

    def zero(self) -> None:
        due = self.log.due_fault(self.name)
        if isinstance(due, NotReady) and not self.log.commanded(self.name, "", "zero"):
            self.raise_due()
        self.journal.command(self.name, "zero", {}, "")
        item = self.log.peek(self.name)
        if item is not None and item.name == "zeroed":
            self.read("zeroed")
        else:
            self.raise_due()


class _ReplayedOperator(_ReplayedDevice):
    def mount(self, geometry: str, size: float, *, owner: str) -> Motion:
        return self.command("mount", {"geometry": geometry, "size": size}, owner)

    def confirm(self, request: str, *, owner: str) -> Motion:
        return self.command("confirm", {"request": request}, owner)


_REPLAYED: dict[str, type[_ReplayedDevice]] = {
    "Arm": _ReplayedArm,
    "Gripper": _ReplayedGripper,
    "DepthCamera": _ReplayedCamera,
    "ForceSensor": _ReplayedForceSensor,
    "Operator": _ReplayedOperator,
}

for _cls in _REPLAYED.values():
    for _name, _method in vars(_cls).items():
        if callable(_method):  # what Python says of a wrong call reads as in the run
            _method.__qualname__ = f"{_cls.__name__.replace('_Replayed', 'Monitored')}.{_name}"


def _is_of(fault: LimitExceeded, wrench: Wrench) -> bool:
    """Whether a fault names the force of a reading: the arm that read it was halted by it."""
    told = re.search(r"force ([-+.\de]+) N", fault.reason)
    return told is not None and math.isclose(float(told[1]), wrench.magnitude, rel_tol=1e-2)


class ReplayedCell:
    """The devices of a record; `kinds` are their interfaces by name."""

    def __init__(self, kinds: Mapping[str, str], log: Log, journal: Journal) -> None:
        self.devices = {name: _REPLAYED[kind](name, log, journal) for name, kind in sorted(kinds.items())}

    def stop(self) -> list[Exception]:
        """End every motion."""
        for device in self.devices.values():
            device.stop()
        return []
