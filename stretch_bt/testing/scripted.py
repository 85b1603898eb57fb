"""A device that says what a test tells it to say, and remembers what it was told to do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.clock import Clock
from stretch_bt.errors import DeviceFault, InvalidInput, NoAnswer
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.interfaces import INTERFACES, DeviceState, MotionState, Reading, readings_of
from stretch_bt.hardware.journal import Journal
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
        if self.stopped is not None:
            return self.stopped
        state = self.states.pop(0) if len(self.states) > 1 else self.states[0]
        if isinstance(state, DeviceFault | NoAnswer):
            raise self.device.called(state)
        if state is not MotionState.MOVING:
            self.stopped = state
            if self.device.moving is self:
                self.device.moving = None
        return state

    def stop(self) -> None:
        """Stop the motion if the device is still its own."""
        if self.device.moving is self:
            self.device.note("stop", {}, self.owner)
            self.device.stop()


@dataclass
class ScriptedDevice:
    """Any device interface, scripted.

    `script` maps the name of a reading (`pose` or `height`, `wrench` or `force`, `opening`, `frame`) to one value, or to a list of values
    of which the last stays: text with a unit, an SI number, or what the reading gives. `motion` lists the states of every motion, of which
    the last stays: `moving`, `done`, `blocked`. In both, `fault: why` and `no answer: why` are raised as what a device that is lost, or has
    no answer, raises; so is a DeviceFault or NoAnswer. What nodes command is kept in `commands`; `moving` is the motion under way.
    """

    kind: str
    script: Mapping[str, Any] = field(default_factory=dict)
    motion: Sequence[MotionState | DeviceFault | NoAnswer | str] = (MotionState.MOVING, MotionState.DONE)
    now: Callable[[], float] = lambda: 0.0
    commands: list[Command] = field(default_factory=list)
    moving: ScriptedMotion | None = None
    ended: bool = False
    state: DeviceState = DeviceState.READY

    def __post_init__(self) -> None:
        if self.kind not in INTERFACES:
            raise InvalidInput(f"{self.kind!r} is not a kind of device; one of {', '.join(INTERFACES)}")
        defaults: dict[str, list[Any]] = {
            "pose": [Pose((0.0, 0.0, 0.2))],
            "wrench": [Wrench((0.0, 0.0, 0.0))],
            "opening": [0.055],
        }
        values = {**defaults, **script_values(self.kind, self.script)}
        self._values = {name: iter_last(given) for name, given in values.items()}
        self._force_noise = float(values.get("force_noise", [0.0])[0])
        self._states = motion_states(self.kind, self.motion)
        self._sequence_number = 0
        self._name = ""
        self._journal: Journal | None = None

    def tell(self, name: str, journal: Journal) -> None:
        """Tell the journal of a run of every command from now on; `name` is what the tree calls the device."""
        self._name, self._journal = name, journal

    def note(self, command: str, arguments: dict[str, Any], owner: str) -> None:
        """Keep a command, and tell the run of it."""
        self.commands.append(Command(command, arguments, owner))
        if self._journal is not None:
            self._journal.command(self._name, command, arguments, owner)

    def called(self, error: DeviceFault | NoAnswer) -> DeviceFault | NoAnswer:
        """Return an error of the script under the name that the tree has for the device, where the script names its kind alone."""
        if isinstance(error, DeviceFault) and self._name and error.device == self.kind.lower():
            return type(error)(self._name, error.reason)
        return error

    def go_by(self, clock: Clock) -> None:
        """Take the time of a run."""
        self.now = clock.now

    @property
    def readings(self) -> Mapping[str, Any]:
        """The readings that expressions may use."""
        return readings_of(INTERFACES[self.kind])

    def _read(self, name: str) -> Reading[Any]:
        if name not in self._values:
            raise InvalidInput(f"the scripted {self.kind} has no {name!r}; give it in 'script'")
        value = next(self._values[name])
        if isinstance(value, DeviceFault | NoAnswer):
            raise self.called(value)
        self._sequence_number += 1
        now = self.now()
        return Reading(value, now, now, self._sequence_number)

    def _command(self, name: str, owner: str, **arguments: Any) -> ScriptedMotion:
        check_owner(self.kind, owner)
        if self.moving is not None:
            self.moving.stopped = MotionState.PREEMPTED
        self.note(name, arguments, owner)
        self.moving = ScriptedMotion(self, owner, self._states)
        return self.moving

    def move(self, target: Any, *, speed: float, owner: str) -> ScriptedMotion:
        """Begin a motion."""
        return self._command("move", owner, target=target, speed=speed)

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
        """Return the scripted noise of the force, none unless one is given."""
        return self._force_noise

    def opening(self, max_age: float) -> Reading[float]:
        """Return the next scripted opening."""
        return self._read("opening")

    def frame(self, max_age: float) -> Reading[Any]:
        """Return the next scripted frame."""
        return self._read("frame")

    def zero(self) -> None:
        """Remember that the sensor was zeroed."""
        self.note("zero", {}, "")

    def open(self) -> None:
        """Be ready."""
        self.state = DeviceState.READY

    def close(self) -> None:
        """Stop and be gone."""
        self.stop()
        self.state = DeviceState.DISCONNECTED

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
