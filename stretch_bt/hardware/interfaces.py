"""What a device does, whoever makes it: the interfaces that nodes, cells and the contract tests share.

Commands start a motion and return at once with a `Motion`; nothing moves on construction or import. A motion has an
owner: starting a new one preempts the old, and only the owner of the current motion can stop it through its handle.
Readings carry their times, and whoever reads states the age it accepts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar, Generic, Protocol, TypeVar, runtime_checkable

from stretch_bt.errors import shown
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.units import Force, Length

__all__ = [
    "INTERFACES",
    "UNWATCHED",
    "Arm",
    "DepthCamera",
    "Device",
    "DeviceState",
    "ForceSensor",
    "Gripper",
    "Motion",
    "MotionState",
    "Operator",
    "Reading",
    "is_one",
    "kind_of",
    "readings_of",
]

T = TypeVar("T")
#: why a motion that nobody polls is stopped
UNWATCHED = (
    "no tick looked at the motion for {:.2g} s: a node hangs or takes too long; see which one, then start a new run"
)


@dataclass(frozen=True, slots=True)
class Reading(Generic[T]):
    """A value, the device's and the host's time of it, s, and a number that grows with each new value."""

    value: T
    device_time: float
    host_time: float
    sequence: int


class DeviceState(StrEnum):
    """Where a device stands; a fault stays until the device is closed and opened again."""

    DISCONNECTED = "disconnected"
    CONNECTING = "connecting"
    READY = "ready"
    FAULT = "fault"


class MotionState(StrEnum):
    """How a motion stands."""

    MOVING = "moving"
    DONE = "done"
    BLOCKED = "blocked"  # it ended before its target: contact, or an object in the fingers
    STOPPED = "stopped"  # its owner, or a safe stop, stopped it
    PREEMPTED = "preempted"  # another owner's command took over


class Motion(Protocol):
    """A motion under way; `owner` is the path of the node that started it."""

    owner: str

    def poll(self) -> MotionState:
        """Return how the motion stands now; raises DeviceFault when the device failed."""
        ...

    def stop(self) -> None:
        """Stop the motion if it is still its device's current one; otherwise do nothing."""
        ...


@runtime_checkable
class Device(Protocol):
    """What every device has."""

    #: readings that expressions may use, by name, with the type of each
    readings: ClassVar[Mapping[str, Any]]

    @property
    def state(self) -> DeviceState:
        """Where the device stands."""
        ...

    def open(self) -> None:
        """Connect, free of an earlier fault; moves nothing. Raises DeviceLost."""
        ...

    def close(self) -> None:
        """Stop and disconnect; may be called in any state, more than once."""
        ...

    def stop(self) -> None:
        """End any motion at once, whoever owns it."""
        ...


@runtime_checkable
class Arm(Device, Protocol):
    """A robot arm that carries the hand; its poses are poses of the hand frame in the world."""

    readings: ClassVar[Mapping[str, Any]] = {"force": Force, "height": Length}

    def move(self, target: Pose, *, speed: float, owner: str) -> Motion:
        """Move in a straight line at `speed`, m/s."""
        ...

    def follow(self, path: Sequence[Pose], *, speed: float, owner: str) -> Motion:
        """Move through the poses at `speed`, m/s, blending between them."""
        ...

    def pose(self, max_age: float) -> Reading[Pose]:
        """Return the hand's pose, at most `max_age` s old; raises StaleReading."""
        ...

    def wrench(self, max_age: float) -> Reading[Wrench]:
        """Return the arm's own estimate of the contact wrench, at most `max_age` s old."""
        ...

    def force_noise(self) -> float:
        """Return the noise of that force, N s^0.5 an axis: the standard deviation of its mean over a time, times the root of the time."""
        ...


@runtime_checkable
class Gripper(Device, Protocol):
    """A parallel gripper that stretches the membrane; openings are in metres between the fingers."""

    readings: ClassVar[Mapping[str, Any]] = {"opening": Length}

    def move(self, opening: float, *, speed: float, owner: str) -> Motion:
        """Open or close to `opening`, m, at `speed`, m/s."""
        ...

    def opening(self, max_age: float) -> Reading[float]:
        """Return the measured opening, m, at most `max_age` s old."""
        ...


@runtime_checkable
class DepthCamera(Device, Protocol):
    """A depth camera that looks at the back of the membrane."""

    readings: ClassVar[Mapping[str, Any]] = {}

    @property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the frames; raises NotReady before the camera is open where only the open camera knows them."""
        ...

    @property
    def ended(self) -> bool:
        """Whether no new frame will ever come, as after the last one of a recording."""
        ...

    def frame(self, max_age: float) -> Reading[DepthFrame]:
        """Return the latest frame, at most `max_age` s old; raises StaleReading."""
        ...


@runtime_checkable
class ForceSensor(Device, Protocol):
    """A force and torque sensor under the object or behind the hand."""

    readings: ClassVar[Mapping[str, Any]] = {"force": Force}

    def wrench(self, max_age: float) -> Reading[Wrench]:
        """Return the wrench since the last `zero`, at most `max_age` s old."""
        ...

    def zero(self) -> None:
        """Take the present wrench as zero."""
        ...


@runtime_checkable
class Operator(Device, Protocol):
    """A person at the cell, who does what the robot cannot."""

    readings: ClassVar[Mapping[str, Any]] = {}

    def mount(self, geometry: str, size: float, *, owner: str) -> Motion:
        """Mount an indenter on the stand in place of what stands there.

        `geometry` is `sphere`, `cylinder` or `cone`; `size` is the diameter, m, and for a cone the angle between its surface
        and the membrane plane, rad.
        """
        ...

    def confirm(self, request: str, *, owner: str) -> Motion:
        """Look at what the robot is about to do, and let it go on."""
        ...


INTERFACES: dict[str, type] = {i.__name__: i for i in (Arm, Gripper, DepthCamera, ForceSensor, Operator)}


def is_one(device: Any, interface: type) -> bool:
    """Whether something is a device of an interface: it says so by its `kind`, as a scripted one does, or has what belongs to it."""
    kind = getattr(device, "kind", None)
    known = isinstance(kind, str) and kind in INTERFACES
    return kind == interface.__name__ if known else isinstance(device, interface)


def kind_of(device: Any) -> str:
    """Return the kind of a device, or what else it is, for messages."""
    return next((name for name, interface in INTERFACES.items() if is_one(device, interface)), shown(device))


def readings_of(interface: type) -> Mapping[str, Any]:
    """Return the readings of an interface that expressions may use, with the type of each."""
    return dict(vars(interface)["readings"])
