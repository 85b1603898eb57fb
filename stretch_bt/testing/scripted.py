"""A device that answers by the script of a test, and remembers its commands."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from stretch_bt.clock import Clock
from stretch_bt.errors import DeviceFault, InvalidInput, NoAnswer, NotReady, StaleReading
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.interfaces import INTERFACES, DeviceState, MotionState, Reading, readings_of
from stretch_bt.hardware.journal import Journal, Relay
from stretch_bt.hardware.owner import check_owner
from stretch_bt.testing.words import motion_states, script_values

__all__ = ["Command", "ScriptedDevice", "ScriptedMotion"]


@dataclass(frozen=True, slots=True)
class Command:
    """A command that a node gave."""

    name: str
    arguments: dict[str, Any]
    owner: str


class ScriptedMotion:
    """A motion that goes through scripted states; the last one stays."""

    def __init__(
        self, device: ScriptedDevice, owner: str, states: Sequence[MotionState | DeviceFault | NoAnswer]
    ) -> None:
        self.owner = owner
        self.device = device
        self.states = list(states)
        self.stopped: MotionState | None = None

    def poll(self) -> MotionState:
        """Return the next state, or raise the next fault or NoAnswer."""
        state = self.stopped or (self.states.pop(0) if len(self.states) > 1 else self.states[0])
        if isinstance(state, DeviceFault | NoAnswer):
            raise self.device.told(state)
        if state is not MotionState.MOVING:
            self.stopped = state
            if self.device.moving is self:
                self.device.moving = None
        self.device.journal.motion(self.device.name, self.owner, state)
        return state

    def stop(self) -> None:
        """Stop the motion if the device is still its own."""
        if self.device.moving is self:
            self.device.note("stop", {}, self.owner)
            self.device.stop()


class ScriptedDevice:
    """Any device interface, scripted; its answers and commands go to the journal of its run, as with a device of a cell.

    Parameters
    ----------
    kind
        Its interface, such as `Arm`.
    script
        Maps the name of a reading (`pose` or `height`, `wrench` or `force`, `force_noise`, `opening`, `frame`) to one value, or to a
        list of values of which the last stays: text with a unit, an SI number, or what the reading gives.
    motion
        The states of every motion, of which the last stays: `moving`, `done`, `blocked`. In both, `fault: why` and `no answer: why` are
        raised as the error of a device that is lost, or has no answer; so is a DeviceFault or NoAnswer.
    now
        The time, s.
    ended
        Whether a camera has nothing new to show.

    Attributes
    ----------
    commands
        What nodes commanded.
    moving
        The motion under way.
    """

    def __init__(
        self,
        kind: str,
        script: Mapping[str, Any] = MappingProxyType({}),
        motion: Sequence[MotionState | DeviceFault | NoAnswer | str] = (MotionState.MOVING, MotionState.DONE),
        now: Callable[[], float] = lambda: 0.0,
        *,
        ended: bool = False,
    ) -> None:
        if kind not in INTERFACES:
            raise InvalidInput(f"{kind!r} is not a kind of device; one of {', '.join(INTERFACES)}")
        self.kind = kind
        self.now = now
        self.commands: list[Command] = []
        self.moving: ScriptedMotion | None = None
        self.state = DeviceState.READY
        defaults: dict[str, list[Any]] = {
            "pose": [Pose((0.0, 0.0, 0.2))],
            "wrench": [Wrench((0.0, 0.0, 0.0))],
            "opening": [0.055],
            "force_noise": [0.0],
        }
        values = {**defaults, **script_values(kind, script)}
        self._values = {name: iter_last(given) for name, given in values.items()}
        self._ended = ended
        self._states = motion_states(kind, motion)
        self._sequence_number = 0
        #: a fault that it reported, after which it takes no command, as any device until it is opened again
        self.fault: DeviceFault | None = None
        #: its name in the tree
        self.name = ""
        self.journal: Journal = Relay()

    def tell(self, name: str, journal: Journal) -> None:
        """Report every reading and command to the journal of a run from now on; `name` is the name of the device in the tree."""
        self.name, self.journal = name, journal

    def note(self, command: str, arguments: dict[str, Any], owner: str) -> None:
        """Keep a command, and report it to the run."""
        self.commands.append(Command(command, arguments, owner))
        self.journal.command(self.name, command, arguments, owner)

    def told(self, error: DeviceFault | NoAnswer) -> DeviceFault | NoAnswer:
        """Report an error of the script to the run, and return it; a fault has the name that the tree has for the device."""
        if isinstance(error, NoAnswer):
            self.journal.unanswered(self.name, error)
            return error
        if self.name and error.device == self.kind.lower():  # a script in words names the kind alone
            error = type(error)(self.name, error.reason)
        if not isinstance(error, StaleReading):
            self.fault = self.fault or error
        self.journal.fault(self.name, error)
        return error

    def go_by(self, clock: Clock) -> None:
        """Take the time of a run."""
        self.now = clock.now

    @property
    def readings(self) -> Mapping[str, Any]:
        """The readings that expressions may use."""
        return readings_of(INTERFACES[self.kind])

    def _read(self, name: str) -> Reading[Any]:
        value = self._next(name)
        self._sequence_number += 1
        return self._said(name, value, self._sequence_number)

    def _next(self, name: str) -> Any:
        """Return the next value of the script, or raise the error that stands there."""
        if name not in self._values:
            raise InvalidInput(f"the scripted {self.kind} has no {name!r}; give it in 'script'")
        value = next(self._values[name])
        if isinstance(value, DeviceFault | NoAnswer):
            raise self.told(value)
        return value

    def _said(self, name: str, value: Any, number: int = 0) -> Reading[Any]:
        now = self.now()
        reading = Reading(value, now, now, number)
        self.journal.reading(self.name, name, reading)
        return reading

    def _command(self, name: str, owner: str, **arguments: Any) -> ScriptedMotion:
        check_owner(self.kind, owner)
        self._refuse_in_fault()
        if self.moving is not None:
            self.moving.stopped = MotionState.PREEMPTED
        self.note(name, arguments, owner)
        self.moving = ScriptedMotion(self, owner, self._states)
        return self.moving

    def _refuse_in_fault(self) -> None:
        if self.fault is not None:
            refused = NotReady(self.name or self.kind.lower(), f"in fault until a new run: {self.fault.reason}")
            self.journal.fault(self.name, refused)
            raise refused

    def move(self, target: Any, *, speed: float, owner: str) -> ScriptedMotion:
        """Begin a motion to a pose, or of a gripper to an opening."""
        what = "opening" if self.kind == "Gripper" else "target"
        return self._command("move", owner, **{what: target}, speed=speed)

    def follow(self, path: Sequence[Pose], *, speed: float, owner: str) -> ScriptedMotion:
        """Begin a motion along a path."""
        return self._command("follow", owner, path=list(path), speed=speed)

    def mount(self, geometry: str, size: float, *, owner: str) -> ScriptedMotion:
        """Begin to mount an indenter."""
        return self._command("mount", owner, geometry=geometry, size=size)

    def confirm(self, request: str, *, owner: str) -> ScriptedMotion:
        """Begin to ask the operator."""
        return self._command("confirm", owner, request=request)

    def pose(self, max_age: float) -> Reading[Pose]:
        """Return the next scripted pose."""
        return self._read("pose")

    def wrench(self, max_age: float) -> Reading[Wrench]:
        """Return the next scripted wrench."""
        return self._read("wrench")

    def force_noise(self) -> float:
        """Return the next scripted noise of the force, N s^0.5 an axis; 0 unless one is given."""
        noise = float(self._next("force_noise"))
        if noise > 0:
            self._said("force_noise", noise)
        return noise

    @property
    def ended(self) -> bool:
        """Whether a camera has nothing new to show."""
        if self._ended:
            self._said("ended", True)
        return self._ended

    def opening(self, max_age: float) -> Reading[float]:
        """Return the next scripted opening."""
        return self._read("opening")

    def frame(self, max_age: float) -> Reading[Any]:
        """Return the next scripted frame."""
        return self._read("frame")

    def zero(self) -> None:
        """Remember that the sensor was zeroed."""
        self._refuse_in_fault()
        self.note("zero", {}, "")
        self._said("zeroed", True)

    def open(self) -> None:
        """Be ready, free of an earlier fault."""
        self.fault = None
        self.state = DeviceState.READY

    def close(self) -> None:
        """Stop and be gone."""
        self.stop()
        self.state = DeviceState.DISCONNECTED

    def release(self, owner: str) -> None:
        """Stop the motion that an owner left under way."""
        motion = self.moving
        if self.fault is None and motion is not None and motion.owner == owner and motion.poll() is MotionState.MOVING:
            motion.stop()

    def stop(self) -> None:
        """End any motion."""
        if self.moving is not None:
            self.moving.stopped = self.moving.stopped or MotionState.STOPPED
            self.moving = None


def iter_last(values: Sequence[Any]) -> Iterator[Any]:
    """Yield the values, and then the last one for ever."""
    yield from values
    while True:
        yield values[-1]
