"""Options of a UR5 or UR5e in a cell file."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from stretch_bt.frames import Pose
from stretch_bt.hardware.address import Address
from stretch_bt.hardware.driver import Bench, Options
from stretch_bt.hardware.ur.settings import Settings
from stretch_bt.units import KINDS, Angle, AngularSpeed, Force, Length, Mass, Time, Within

__all__ = ["Placement", "UrOptions"]

_Place = Annotated[Length, Within(-5.0, 5.0, "Length")]
_Turn = Annotated[Angle, Within(-2 * math.pi, 2 * math.pi, "Angle")]
_Acceleration = Annotated[float, KINDS["Acceleration"], Within(0.01, 5.0, "Acceleration")]
_Rate = Annotated[float, KINDS["Frequency"], Within(10.0, 500.0, "Frequency")]
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

    mass: Annotated[Mass, Within(0.0, 5.0, "Mass")]
    x: _Place = Field(default=0.0, description="centre of mass, from the flange")
    y: _Place = 0.0
    z: _Place = 0.0


class UrOptions(Options):
    """Where the robot is, how the hand is mounted, and what watches over it."""

    type: Literal["Arm"]
    use: Literal["ur"]
    host: Address = Field(description="address of the controller")
    model: Literal["ur5", "ur5e"]
    base: Placement = Field(description="of the robot's base in the world, measured")
    hand: Placement = Field(
        description="of the hand (centre of the flat membrane, z away from the object) at the flange"
    )
    source: str = Field(min_length=1, description="who measured `base`, `hand` and `payload`, on which robot, when")
    payload: _Payload | None = Field(default=None, description="else what the installation at the pendant says")
    tare: bool = Field(default=False, description="take the force at opening as zero; the hand must touch nothing then")
    rate: _Rate = Field(default=125.0, description="of reading, checking and leading the hand")
    acceleration: _Acceleration = Field(default=0.5, description="at the begin and the end of each motion")
    stop_acceleration: _Acceleration = Field(
        default=2.0, description="of stopping before the end; more where the watchdog would not wait"
    )
    lookahead: Annotated[Time, Within(0.03, 0.2, "Time")] = Field(default=0.05, description="of the controller's servo")
    gain: Annotated[float, Within(100.0, 2000.0)] = Field(default=300.0, description="of the controller's servo")
    joint_speed: Annotated[AngularSpeed, Within(0.01, math.pi, "AngularSpeed")] = Field(
        default=1.0, description="that no motion may ask of a joint"
    )
    margin: Annotated[float, Within(0.0, 0.5)] = Field(
        default=0.05, description="to where the arm is stretched out or folded: sines of elbow and wrist, and m"
    )
    tolerance: Annotated[Length, Within(0.0001, 0.01, "Length")] = Field(
        default=0.001, description="how far from its target a motion may end"
    )
    contact_force: Annotated[Force, Within(0.5, 200.0, "Force")] | None = Field(
        default=None, description="gained on the way at which a motion ends as blocked; none ends so without it"
    )
    registers: Literal["lower", "upper"] = Field(default="upper", description="of RTDE that the control script uses")
    watchdog: _Watchdog = Field(
        default=5.0, description="of the controller: it stops the arm without a command this often"
    )
    lost_after: Annotated[Time, Within(0.05, 2.0, "Time")] = Field(
        default=0.2, description="without news from the controller"
    )
    heartbeat: Annotated[Time, Within(0.1, 5.0, "Time")] = Field(
        default=0.5, description="without a sign of life from the run after which the arm is stopped"
    )

    def settings(self, bench: Bench) -> Settings:
        """Return what the process of the arm goes by."""
        limits, given = bench.limits, self.payload
        named = {name: getattr(self, name) for name in _SHARED}
        return Settings(
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
            unwatched=limits.unwatched,
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
    "heartbeat",
    "tolerance",
    "contact_force",
)
