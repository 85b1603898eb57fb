"""What the nodes of a run share: its time, its hand, its devices, and the readings that the last node was given."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from stretch_bt.errors import DeviceFault, NoAnswer, NotReady
from stretch_bt.frames import DepthFrame, Pose, Wrench
from stretch_bt.hardware.ages import EXPRESSION_FORCE, PLACE
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.journal import Journal, Relay
from stretch_bt.hardware.limits import Limits

__all__ = ["Commanded", "RunContext", "Seen"]

#: commands that a result keeps, the latest ones: a run may take days
COMMANDS = 10_000

#: largest delay of the first tick, from which the grid counts, against other ticks, as a part of a period
_EARLY = 0.25

_READERS: dict[str, Callable[[Any], float]] = {
    "force": lambda device: device.wrench(EXPRESSION_FORCE).value.magnitude,
    "height": lambda device: device.pose(PLACE).value.height,
    "opening": lambda device: device.opening(PLACE).value,
}


class Commanded(NamedTuple):
    """A command that a node gave: when, s of the run's clock, to which device, and the path of the node."""

    time: float
    device: str
    name: str
    arguments: Mapping[str, Any]
    owner: str


class Seen:
    """A journal that passes everything on, and keeps the latest reading of each kind and the latest commands."""

    def __init__(self, inner: Journal | None = None, now: Callable[[], float] = lambda: 0.0) -> None:
        self.inner: Journal = inner or Relay()
        self.now = now
        self.latest: dict[str, Reading[Any]] = {}
        self.commands: deque[Commanded] = deque(maxlen=COMMANDS)

    def shown(self) -> dict[str, Any]:
        """Return the latest readings in a few words each."""
        return {name: _brief(reading.value) for name, reading in sorted(self.latest.items())}

    def reading(self, device: str, name: str, reading: Reading[Any]) -> None:
        """Keep it and pass it on."""
        self.latest[f"{device}.{name}"] = reading
        self.inner.reading(device, name, reading)

    def command(self, device: str, name: str, arguments: Mapping[str, Any], owner: str) -> None:
        """Keep it and pass it on."""
        self.commands.append(Commanded(self.now(), device, name, arguments, owner))
        self.inner.command(device, name, arguments, owner)

    def motion(self, device: str, owner: str, state: MotionState) -> None:
        """Pass it on."""
        self.inner.motion(device, owner, state)

    def fault(self, device: str, fault: DeviceFault) -> None:
        """Pass it on."""
        self.inner.fault(device, fault)

    def unanswered(self, device: str, none: NoAnswer) -> None:
        """Pass it on."""
        self.inner.unanswered(device, none)


def _brief(value: Any) -> Any:
    if isinstance(value, DepthFrame):
        return {"frame": value.sequence, "time": value.time, "valid": round(float((value.raw > 0).mean()), 4)}
    if isinstance(value, Pose):
        return {"position": list(value.position), "rotation": list(value.rotation)}
    return {"force": list(value.force), "torque": list(value.torque)} if isinstance(value, Wrench) else value


class RunContext:
    """The context of one run; `devices` stays empty until the cell is open, and for mocked runs."""

    def __init__(self, hand: Hand | None = None) -> None:
        self.now = 0.0
        self.start = 0.0
        self.period = 0.0
        self.ticks = 0
        self.hand = hand or Hand()
        self.memory: dict[Any, Any] = {}
        self.limits: Limits | None = None
        self.about: Mapping[str, Any] = {}
        self.folder: Path | None = None
        self.repeated: Path | None = None
        self.devices: Mapping[str, Any] = {}
        #: readings that a mocks file gives instead of a device's
        self.mocked_readings: dict[str, Callable[[], float]] = {}

    @property
    def time(self) -> float:
        """Time since the run began, s."""
        return self.now - self.start

    @property
    def slot(self) -> int:
        """Place of this tick on the grid of the run's ticks; one that comes up to three quarters of a period late has its own."""
        return math.floor(self.time / self.period + _EARLY) if self.period > 0 else self.ticks

    def device(self, name: str) -> Any:
        """Return a device of the cell; raises NotReady when the run has none of this name."""
        try:
            return self.devices[name]
        except KeyError:
            raise NotReady(name, "this run has no such device; name a scene or a cell") from None

    def reading(self, device: str, name: str) -> float:
        """Return a reading for an expression."""
        mocked = self.mocked_readings.get(f"{device}.{name}")
        if mocked is not None:
            return mocked()
        return _READERS[name](self.device(device))
