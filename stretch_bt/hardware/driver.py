"""What an implementation of a device provides; ownership, limits, ages and faults are added around it by `monitored`.

A driver is constructed from its options in the cell file and a `CellContext`, touches nothing until `open`, and raises
DeviceFault when the device fails. The poll function that a command returns reports the state of that motion as long as no
other command follows.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, ConfigDict

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.peak_force import Stopping

if TYPE_CHECKING:
    from stretch_bt.hardware.simulated.twin import Twin
    from stretch_bt.simulation.scene import Scene

__all__ = [
    "ArmDriver",
    "CellContext",
    "DepthCameraDriver",
    "Driver",
    "ForceSensorDriver",
    "GripperDriver",
    "Mistake",
    "OperatorDriver",
    "Options",
    "Poll",
    "missing_file",
]

Poll = Callable[[], MotionState]
Mistake = tuple[str, str, str]


def missing_file(root: Path, option: str, file: str) -> Iterator[Mistake]:
    """Yield that a file that an option names is not there, if it is not."""
    if not (root / file).is_file():
        yield option, f"there is no file {file!r} beside the cell file", "write a path relative to the cell file"


class Options(BaseModel):
    """Options of an implementation in a cell file; each class names its interface and itself in `type` and `use`."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    def given(self) -> Any:
        """Return what the driver gets: these options, or the dataclass that its author wrote them in."""
        return self

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield (key, mistake, what to write instead) for mistakes that only show in the files that the options name."""
        yield from ()

    def halt(self, name: str) -> Finding | None:
        """Stop the device of this name from outside of a run, beside one too; None where its driver does that as it opens it."""
        return None

    def openings(self) -> tuple[float, float] | None:
        """Return the least and the greatest opening, m, that a gripper can have, where this is one."""
        return None

    def stopping(self, limits: Limits) -> Stopping | None:
        """Return how an arm with these options stops because of a force, where this is an arm that something real can stop."""
        return None

    def force_noise(self) -> float:
        """Return the noise of the force that an arm with these options shows, N s^0.5 an axis; 0 where it is not known before."""
        return 0.0


@dataclass(frozen=True)
class CellContext:
    """What the drivers of one cell share: clock, seed, hand, limits, the folder of the cell file, and the twin."""

    now: Callable[[], float]
    seed: int
    root: Path
    hand: Hand
    limits: Limits
    scene: Scene | None = None

    @cached_property
    def twin(self) -> Twin:
        """The simulated world that all simulated devices of the cell act on."""
        if self.scene is None:
            raise InvalidInput("a simulated cell needs a scene; name one")
        from stretch_bt.hardware.simulated.twin import Twin

        return Twin(self.scene, self.hand.geometry, self.now, self.seed)


class Driver:
    """What every driver has; constructing it keeps these three and touches nothing.

    `Options` is a frozen dataclass, or a class derived from `Options` of this module; a driver without it has no options.
    """

    Options: ClassVar[type[Any]] = Options
    #: name in cell files of a driver that a cell file imports; by default its class name in snake case, or the name of its entry point
    use: ClassVar[str] = ""
    simulated: ClassVar[bool] = False
    #: whether it goes by whatever clock it is given; a real device goes by the machine's
    any_clock: ClassVar[bool] = False
    #: whether its readings come from another thread or process, so that a moment's wait may bring a newer one
    streams: ClassVar[bool] = False
    #: modules that it imports when it is opened, and the packages that they are in
    packages: ClassVar[Mapping[str, str]] = {}

    def __init__(self, name: str, options: Any, cell: CellContext) -> None:
        self.name = name
        self.options = options
        self.cell = cell

    def now(self) -> float:
        """Return the time of the run, s: readings and motions go by it."""
        return self.cell.now()

    @property
    def folder(self) -> Path:
        """Folder of the cell file, to which the files in its options are relative."""
        return self.cell.root

    @property
    def ended(self) -> bool:
        """Whether nothing new will ever come, as after the last frame of a recording."""
        return False

    def claimed(self) -> str | None:
        """Return which device, and where, only one program may use at a time; None where several may."""
        return None

    def open(self) -> None:
        """Connect; moves nothing."""

    def open_to_read(self) -> None:
        """Connect as far as readings need it; takes nothing into use that somebody else may be using."""
        self.open()

    def unready(self) -> str | None:
        """Return what keeps an open device from taking commands, and what to do; None when nothing does."""
        return None

    def findings(self) -> Iterator[Finding]:
        """Yield what a look from outside finds, before the device is opened."""
        yield from ()

    def close(self) -> None:
        """Disconnect; may be called more than once."""

    def stop(self) -> None:
        """End any motion at once."""

    def hold(self) -> None:
        """End any motion at once, also one that somebody else began; the same as `stop` unless a driver says so."""
        self.stop()


class ArmDriver(Driver, ABC):
    """Moves a robot arm."""

    @abstractmethod
    def follow(self, path: Sequence[Pose], speed: float) -> Poll:
        """Move through the poses, one or more, in straight lines."""

    @abstractmethod
    def pose(self) -> Reading[Pose]:
        """Return the latest measured pose of the hand."""

    @abstractmethod
    def wrench(self) -> Reading[Wrench]:
        """Return the latest estimate of the contact wrench."""

    def force_noise(self) -> float:
        """Return the noise of the force, N s^0.5 an axis; none unless a driver says so."""
        return 0.0


class GripperDriver(Driver, ABC):
    """Moves a gripper."""

    @abstractmethod
    def move(self, opening: float, speed: float) -> Poll:
        """Move the fingers to an opening, m."""

    def activate(self) -> Poll:
        """Make ready to move, which may take the fingers all their way; there is nothing to do unless a driver says so."""
        return lambda: MotionState.DONE

    @abstractmethod
    def opening(self) -> Reading[float]:
        """Return the latest measured opening, m."""

    def count(self) -> int | None:
        """Return the gripper's own number of where its fingers stand, or None where it has none; raises DeviceFault."""
        return None


class DepthCameraDriver(Driver, ABC):
    """Delivers depth frames."""

    @property
    @abstractmethod
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the frames; raises NotReady before `open` where only the camera knows them."""

    @abstractmethod
    def frame(self) -> Reading[DepthFrame]:
        """Return the latest frame."""


class ForceSensorDriver(Driver, ABC):
    """Delivers wrenches."""

    @abstractmethod
    def wrench(self) -> Reading[Wrench]:
        """Return the latest wrench since the last `zero`."""

    @abstractmethod
    def zero(self) -> None:
        """Take the present wrench as zero."""


class OperatorDriver(Driver, ABC):
    """Asks a person."""

    @abstractmethod
    def mount(self, geometry: str, size: float) -> Poll:
        """Have an indenter mounted; `size` is a diameter, m, or an angle, rad."""

    @abstractmethod
    def confirm(self, request: str) -> Poll:
        """Ask whether to go on."""
