"""Inputs of a cycle of the process of an arm, the state that is kept from one to the next, and the outputs."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.messages import Message
from stretch_bt.hardware.ur.force_filter import ForceFilter
from stretch_bt.hardware.ur.guard import MeasuredState
from stretch_bt.hardware.ur.messages import Engaged, Six
from stretch_bt.hardware.ur.ride import Ride
from stretch_bt.hardware.ur.standing_force import StandingForce

__all__ = [
    "Brake",
    "Command",
    "ControlState",
    "Feeling",
    "GiveUp",
    "Inputs",
    "Kick",
    "Leave",
    "MakeReady",
    "Say",
    "Servo",
]

_NONE: Six = (0.0,) * 6
_ORIGIN = Pose()


@dataclass(frozen=True, slots=True)
class Inputs:
    """What came in since the cycle before."""

    #: the data that the controller sent, where they are new
    measured: MeasuredState | None = None
    messages: tuple[Message, ...] = ()
    #: whether the arm still brakes
    braking: bool = False
    #: result of `MakeReady`
    engaged: Engaged | None = None
    #: whether the control script took the last setpoint
    taken: bool = True
    #: for how long the machine did not run this process beyond its period, s: nobody was silent towards it then
    late: float = 0.0


@dataclass(frozen=True, slots=True)
class Servo:
    """Send the hand to a place in the base."""

    hand: Six


@dataclass(frozen=True, slots=True)
class Brake:
    """Bring the arm to rest."""


@dataclass(frozen=True, slots=True)
class Kick:
    """Feed the controller's watchdog."""


@dataclass(frozen=True, slots=True)
class MakeReady:
    """Make the arm ready to move, for the request of a number."""

    number: int


@dataclass(frozen=True, slots=True)
class Say:
    """Send a message to the driver."""

    message: Message


@dataclass(frozen=True, slots=True)
class Leave:
    """End, as the driver asks."""


@dataclass(frozen=True, slots=True)
class GiveUp:
    """End, because the arm is lost."""

    reason: str


Command = Servo | Brake | Kick | MakeReady | Say | Leave | GiveUp


@dataclass(frozen=True, slots=True)
class Feeling:
    """A mean of the force that is being taken, for the request of a number: until when, by the controller's clock, s."""

    number: int
    until: float
    samples: tuple[Six, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class ControlState:
    """The state that is kept from cycle to cycle; times are by the monotonic clock, s, where nothing else is said."""

    #: times of the latest sign of life of the run, news from the controller, look of a tick at the motion, and setpoint that was taken
    heard: float
    news: float
    watched: float
    taken: float
    force: ForceFilter
    standing: StandingForce
    zero: Six = _NONE
    #: request of a zero that no state was sent with yet, by its number
    zeroing: int | None = None
    #: number of the latest news, and what they were
    number: int = 0
    measured: MeasuredState | None = None
    #: the hand's deviation from nominal kinematics, its place in the base, and its pose in the world
    deviation: Six = _NONE
    hand: Six = _NONE
    pose: Pose = _ORIGIN
    contact_height: float | None = None
    ride: Ride | None = None
    #: force as the motion began, N
    force_before: float = 0.0
    motion: int = 0
    motion_state: MotionState = MotionState.DONE
    fault: str | None = None
    #: whether the arm takes motions, and whether it is held to the limits
    engaged: bool = False
    guarded: bool = False
    feeling: Feeling | None = None
    #: messages still to be dealt with, in this order; while the arm brakes they wait
    waiting: tuple[Message, ...] = ()
