"""What the driver of an arm and its process say to each other; SI, poses as position, m, and rotation vector, rad."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.messages import Answer, Codec, Message, Request

__all__ = [
    "CODEC",
    "Alive",
    "ArmState",
    "Beat",
    "ControllerSettings",
    "Engage",
    "Engaged",
    "Feel",
    "Follow",
    "Guard",
    "Guarded",
    "Left",
    "MeanWrench",
    "Six",
    "Stop",
    "Stopped",
    "Zero",
    "Zeroed",
]

Six = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class ControllerSettings(Message):
    """To the process, first: everything that it goes by."""

    host: str
    model: str
    #: robot's base in the world, and hand at the flange
    base: Six
    hand: Six
    rate: float
    acceleration: float
    stop_acceleration: float
    lookahead: float
    gain: float
    watchdog: float
    upper_registers: bool
    #: mass, kg, and centre of mass at the flange, m
    payload: tuple[float, float, float, float] | None
    lost_after: float
    #: whether no two of its forces are alike
    noisy: bool
    heartbeat: float
    tolerance: float
    contact_force: float | None
    #: time over which the force is averaged, s
    force_filter: float
    #: spans of the hand in the world, and the cell's other limits
    x: tuple[float, float]
    y: tuple[float, float]
    height: tuple[float, float]
    speed: float
    depth: float
    force: float
    #: limit of a single sample of the force, N
    sample_force: float
    #: how long a motion goes on that no tick looks at, s
    unwatched: float
    #: below which height, m, the hand may meet something, and how fast it may be there, m/s
    contact_below: float | None
    contact_speed: float


@dataclass(frozen=True, slots=True)
class Beat(Message):
    """To the process: a sign of life, the world height of first contact, m, once it is known, and when a tick looked at the motion last, s."""

    contact_height: float | None
    watched: float


@dataclass(frozen=True, slots=True)
class Engage(Request):
    """To the process: make the arm ready to move; moves nothing."""


@dataclass(frozen=True, slots=True)
class Engaged(Answer):
    """From the process: the arm is ready, or why it is not, and whether a program of ours may have been begun for that."""

    reason: str | None
    begun: bool = True


@dataclass(frozen=True, slots=True)
class Feel(Request):
    """To the process: average the force over a time, s."""

    over: float


@dataclass(frozen=True, slots=True)
class MeanWrench(Answer):
    """From the process: the mean of the controller's wrenches, in base axes, and of how many."""

    wrench: Six
    count: int


@dataclass(frozen=True, slots=True)
class Zero(Request):
    """To the process: the wrench that counts as none from now on, in base axes."""

    wrench: Six


@dataclass(frozen=True, slots=True)
class Zeroed(Answer):
    """From the process: a state without that wrench was sent."""


@dataclass(frozen=True, slots=True)
class Guard(Request):
    """To the process: hold the limits from now on."""


@dataclass(frozen=True, slots=True)
class Guarded(Answer):
    """From the process: the limits are held, or what is past one already."""

    reason: str | None


@dataclass(frozen=True, slots=True)
class Follow(Request):
    """To the process: lead the hand through poses in the world, at a speed, m/s. It is not answered: the state has its number."""

    path: tuple[Six, ...]
    speed: float


@dataclass(frozen=True, slots=True)
class Stop(Request):
    """To the process: brake."""


@dataclass(frozen=True, slots=True)
class Stopped(Answer):
    """From the process: the arm stands."""


@dataclass(frozen=True, slots=True)
class ArmState(Message):
    """From the process: how the arm stands in one cycle. The pose is the hand's in the robot's base; the wrench is in base axes."""

    #: the controller's time, s, and the number of the cycle
    time: float
    number: int
    q: Six
    pose: Six
    speed: Six
    #: averaged, less the zero
    wrench: Six
    #: whether the controller runs a program
    program: bool
    #: the motion that was begun last, by its number, and how it stands
    motion: int = 0
    motion_state: MotionState = MotionState.DONE
    #: why the arm takes no motion, if it takes none
    fault: str | None = None
    engaged: bool = False


@dataclass(frozen=True, slots=True)
class Alive(Message):
    """From the process: a sign of life in a cycle without news from the controller."""


@dataclass(frozen=True, slots=True)
class Left(Message):
    """From the process, at its end: whether the controller still runs a program."""

    program: bool


CODEC = Codec(
    *(
        ControllerSettings,
        Beat,
        Engage,
        Engaged,
        Feel,
        MeanWrench,
        Zero,
        Zeroed,
        Guard,
        Guarded,
        Follow,
        Stop,
        Stopped,
        ArmState,
        Alive,
        Left,
    )
)
