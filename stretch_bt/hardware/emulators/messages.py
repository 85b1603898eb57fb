"""What the processes of stand-ins and of the twin behind them say to each other, and to whoever began them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stretch_bt.hardware.emulators.setting import Setting
from stretch_bt.hardware.messages import Codec, Message

__all__ = [
    "SCENE",
    "STAND_IN",
    "TWIN",
    "Brake",
    "Clear",
    "Describe",
    "Described",
    "Done",
    "FeltForce",
    "Fingers",
    "HandAt",
    "Inject",
    "LatestFrame",
    "Noise",
    "Ready",
    "Renew",
    "Serve",
    "Serving",
    "Solve",
    "TwinRefused",
]


@dataclass(frozen=True, slots=True)
class TwinRefused(Message):
    """From either process: why it does not do what it was asked."""

    reason: str


@dataclass(frozen=True, slots=True)
class Serve(Message):
    """To a stand-in's process, the first: which one, on which address and ports, and where it stands."""

    name: str
    host: str
    ports: dict[str, int] | None
    activated: bool
    seed: int
    setting: Setting | None


@dataclass(frozen=True, slots=True)
class Serving(Message):
    """From there: where its wires are."""

    wires: dict[str, str]


@dataclass(frozen=True, slots=True)
class Inject(Message):
    """To there: begin to show a fault."""

    fault: str
    parameters: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Clear(Message):
    """To there: end a fault, or all of them."""

    fault: str | None


@dataclass(frozen=True, slots=True)
class Describe(Message):
    """To there: say how the device stands."""


@dataclass(frozen=True, slots=True)
class Done(Message):
    """From there: that it is done."""


@dataclass(frozen=True, slots=True)
class Described(Message):
    """From there: which faults it shows, and how the device stands."""

    active: list[str]
    state: dict[str, Any]


STAND_IN = Codec(TwinRefused, Serve, Serving, Inject, Clear, Describe, Done, Described)


@dataclass(frozen=True, slots=True)
class Solve(Message):
    """To the twin's process, the first: the scene, and what each stand-in needs of it, `felt` and `seen`."""

    setting: Setting
    senses: list[list[str]]


@dataclass(frozen=True, slots=True)
class Ready(Message):
    """From there: that the stand-ins may begin."""


@dataclass(frozen=True, slots=True)
class Renew(Message):
    """To there: put a new object, as it was at first, in the place of the present one."""


TWIN = Codec(TwinRefused, Solve, Ready, Renew, Done)


@dataclass(frozen=True, slots=True)
class HandAt(Message):
    """From a stand-in to the twin: where the hand is at a time, s, as position, m, and rotation vector, rad, in the world."""

    time: float
    pose: list[float]


@dataclass(frozen=True, slots=True)
class Fingers(Message):
    """From a stand-in to the twin: at a time, s, the fingers begin to move to an opening, m, at a speed, m/s."""

    time: float
    to: float
    speed: float


@dataclass(frozen=True, slots=True)
class Brake(Message):
    """From a stand-in to the twin: at a time, s, the fingers begin to brake."""

    time: float


@dataclass(frozen=True, slots=True)
class FeltForce(Message):
    """From the twin to a stand-in: the force on the hand, N, world axes, as each kind of device feels it without its noise."""

    forces: dict[str, list[float]]


@dataclass(frozen=True, slots=True)
class Noise(Message):
    """From the twin to a stand-in: the standard deviation, N an axis, that the scene gives the force of kinds of devices."""

    sds: dict[str, float]


@dataclass(frozen=True, slots=True)
class LatestFrame(Message):
    """From the twin to a stand-in: up to which frame there are pictures, and the number of the latest one."""

    frame: int
    picture: int


SCENE = Codec(HandAt, Fingers, Brake, FeltForce, Noise, LatestFrame)
