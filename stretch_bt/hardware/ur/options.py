"""Options of a UR5 or UR5e in a cell file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from stretch_bt.frames import Pose
from stretch_bt.hardware.address import Address
from stretch_bt.hardware.driver import CellContext, Mistake, Options
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.least_force import least_limit
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.peak_force import Stopping
from stretch_bt.hardware.ur.force_sensing import FORCE_SENSING, sample_limit
from stretch_bt.hardware.ur.messages import ControllerSettings
from stretch_bt.units import KINDS, Angle, AngularSpeed, Force, Length, Mass, Time
from stretch_bt.within import Within

__all__ = ["Placement", "UrOptions"]

_Place = Annotated[Length, Within(-5.0, 5.0, "Length")]
_Turn = Annotated[Angle, Within(-2 * math.pi, 2 * math.pi, "Angle")]
_Acceleration = Annotated[float, KINDS["Acceleration"], Within(0.01, 5.0, "Acceleration")]
_Rate = Annotated[float, KINDS["Frequency"], Within(10.0, 500.0, "Frequency")]
#: cycles of the controller, 1/s
_CONTROLLER = {"ur5": 125.0, "ur5e": 500.0}
#: time in which the client hands a stop to the control script, s: median of a command on loopback
_HANDSHAKE = 0.004
#: periods of `rate` for which news may not be seen while all is well: one until it comes, one until it is looked at
_NEWS = 2
_Watchdog = Annotated[float, KINDS["Frequency"], Within(1.0, 60.0, "Frequency")]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Placement(_Model):
    """Position, and rotation vector."""

    x: _Place = 0.0
    y: _Place = 0.0
    z: _Place = 0.0
    rx: _Turn = 0.0
    ry: _Turn = 0.0
    rz: _Turn = 0.0

    @property
    def pose(self) -> Pose:
        """The same as a pose."""
        return Pose((self.x, self.y, self.z), (self.rx, self.ry, self.rz))


class _Payload(_Model):
    """Everything that hangs at the flange."""

    mass: Annotated[Mass, Within(0.0, 5.0, "Mass")] = Field(
        description="all that hangs at the flange, where `payload` is given; else the installation at the pendant counts"
    )
    x: _Place = Field(default=0.0, description="centre of mass, from the flange")
    y: _Place = 0.0
    z: _Place = 0.0


class UrOptions(Options):
    """Where the robot is, how the hand is mounted, and what watches over it."""

    type: Literal["Arm"]
    use: Literal["ur"]
    host: Address = Field(description="address of the controller")
    model: Literal["ur5", "ur5e"]
    base: Placement = Field(description="pose of the robot's base in the world, measured")
    hand: Placement = Field(
        description="pose of the hand (centre of the flat membrane, z away from the object) at the flange"
    )
    source: str = Field(min_length=1, description="who measured `base`, `hand` and `payload`, on which robot, when")
    payload: _Payload | None = Field(
        default=None, description="load at the flange; by default the one of the installation at the pendant"
    )
    tare: bool = Field(
        default=True, description="whether the force at opening is taken as zero; the hand must touch nothing then"
    )
    loaded: bool = Field(
        default=False, description="whether it opens also where the force at opening is more than bias and noise"
    )
    force_filter: Annotated[Time, Within(0.008, 1.0, "Time")] | None = Field(
        default=None,
        description="time over which the force is averaged, for nodes up to 2 s where samples did not come; "
        "by default 0.128 s for a ur5 and 0.032 s for a ur5e",
    )
    rate: _Rate = Field(default=125.0, description="rate of reading, checking and leading the hand")
    acceleration: _Acceleration = Field(default=0.5, description="acceleration at the begin and the end of each motion")
    stop_acceleration: _Acceleration = Field(
        default=2.0, description="deceleration of a stop before the end; more where the watchdog would not wait"
    )
    lookahead: Annotated[Time, Within(0.03, 0.2, "Time")] = Field(
        default=0.05, description="lookahead time of the controller's servo"
    )
    gain: Annotated[float, Within(100.0, 2000.0)] = Field(default=300.0, description="gain of the controller's servo")
    joint_speed: Annotated[AngularSpeed, Within(0.01, math.pi, "AngularSpeed")] = Field(
        default=1.0, description="largest speed that a motion may ask of a joint"
    )
    margin: Annotated[float, Within(0.0, 0.5)] = Field(
        default=0.05,
        description="least distance to where the arm is stretched out or folded: sines of elbow and wrist, and m",
    )
    tolerance: Annotated[Length, Within(0.0001, 0.01, "Length")] = Field(
        default=0.001, description="largest distance of a motion's end from its target"
    )
    contact_force: Annotated[Force, Within(0.5, 200.0, "Force")] | None = Field(
        default=None, description="force gained on the way at which a motion ends as blocked; none ends so without it"
    )
    registers: Literal["lower", "upper"] = Field(
        default="upper", description="registers of RTDE that the control script uses"
    )
    watchdog: _Watchdog = Field(
        default=5.0, description="least rate of commands, below which the controller stops the arm"
    )
    lost_after: Annotated[Time, Within(0.05, 2.0, "Time")] = Field(
        default=0.12, description="time without news from the controller after which it counts as lost"
    )
    noisy: bool = Field(
        default=True,
        description="whether no two forces are alike, so that one that stands is found; false where a simulation has no noise",
    )
    heartbeat: Annotated[Time, Within(0.1, 5.0, "Time")] = Field(
        default=0.5, description="time without a sign of life from the run after which the arm is stopped"
    )

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield deadlines that pass between two cycles, and a contact that noise makes."""
        cycles, least = _CONTROLLER[self.model], least_limit(self.force_noise(), self._force_filter)
        if self.rate > cycles:
            yield (
                "rate",
                f"a {self.model} has {cycles:g} cycles a second, not {self.rate:g}",
                f"write {cycles:g} Hz or less",
            )
        if self.lost_after < _NEWS / self.rate:
            told = f"news that comes {self.rate:g} times a second is looked at {1e3 * _NEWS / self.rate:.4g} ms later at worst"
            yield "lost_after", told, f"write {math.ceil(1e3 * _NEWS / self.rate)} ms or more, or a higher `rate`"
        if self.watchdog >= self.rate:
            told = (
                f"commands that come {self.rate:g} times a second never keep a watchdog of {self.watchdog:g} Hz quiet"
            )
            yield "watchdog", told, f"write less than {self.rate:g} Hz, such as 5 Hz"
        if self.contact_force is not None and self.contact_force < least:
            told = f"the noise of a {self.model} passes {self.contact_force:g} N with nothing in the way"
            yield "contact_force", told, f"write {math.ceil(least)} N or more, or a longer `force_filter`"

    def halt(self, name: str) -> Finding:
        """Stop the control script by the dashboard: the driver would begin one of its own."""
        from stretch_bt.hardware.ur.halt import halt

        return halt(name, self)

    @property
    def _force_filter(self) -> float:
        return self.force_filter or FORCE_SENSING[self.model].filter

    def stopping(self, limits: Limits) -> Stopping:
        """Return how the arm stops because of a force.

        A force reaches the driver's process within a cycle of the controller and is compared within one of the process; the stop begins
        within a handshake of the client and another cycle of the controller. The watchdog adds nothing: without new setpoints the hand
        stands at the last one.
        """
        return Stopping(
            averaged=self._force_filter,
            single=sample_limit(limits.force),
            delay=2 / _CONTROLLER[self.model] + 1 / self.rate + _HANDSHAKE,
            deceleration=self.stop_acceleration,
            late=self.lost_after,
            lag=self.lookahead,
        )

    def force_noise(self) -> float:
        """Return the noise of the controller's force, N s^0.5 an axis."""
        return FORCE_SENSING[self.model].deviation / math.sqrt(self.rate)

    def settings(self, cell: CellContext) -> ControllerSettings:
        """Return what the process of the arm goes by."""
        limits, given = cell.limits, self.payload
        named = {name: getattr(self, name) for name in _SHARED}
        return ControllerSettings(
            **named,
            base=(*self.base.pose.position, *self.base.pose.rotation),
            hand=(*self.hand.pose.position, *self.hand.pose.rotation),
            payload=None if given is None else (given.mass, given.x, given.y, given.z),
            upper_registers=self.registers == "upper",
            x=(limits.x.min, limits.x.max),
            y=(limits.y.min, limits.y.max),
            height=(limits.height.min, limits.height.max),
            speed=limits.speed,
            depth=limits.depth,
            force=limits.force,
            force_filter=self._force_filter,
            sample_force=sample_limit(limits.force),
            unwatched=limits.unwatched,
            contact_below=None if limits.contact is None else limits.contact.below,
            contact_speed=limits.span("contact_speed")[1],
        )


#: options that the process has by the same name
_SHARED = (
    "host",
    "model",
    "rate",
    "acceleration",
    "stop_acceleration",
    "lookahead",
    "gain",
    "watchdog",
    "lost_after",
    "noisy",
    "heartbeat",
    "tolerance",
    "contact_force",
)
