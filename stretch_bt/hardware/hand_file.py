"""Files that hold the calibration of a hand: the camera in it, and openings of the gripper, with standard deviations and where they are from."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from stretch_bt.hardware.robotiq.calibration import GripperCalibration
from stretch_bt.units import Angle, Length
from stretch_bt.within import Within

__all__ = ["FORMAT", "TURNS", "HandFile", "written"]

FORMAT = "stretch-hand/1"
#: angles of the camera's pose; the others are lengths
TURNS = ("tilt_x", "tilt_y", "yaw")
_Offset = Annotated[Length, Within(-0.1, 0.1, "Length")]
_Distance = Annotated[Length, Within(0.02, 2.0, "Length")]
_LengthSd = Annotated[Length, Within(0.0, 0.1, "Length")]
_TurnSd = Annotated[Angle, Within(0.0, 0.6, "Angle")]
_Turn = Annotated[Angle, Within(-0.6, 0.6, "Angle")]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class _Camera(_Model):
    """The camera in the membrane frame: turned about x, then y, then z; where its axis meets the membrane's plane is `aim`."""

    x: _Offset
    y: _Offset
    distance: _Distance
    tilt_x: _Turn
    tilt_y: _Turn
    yaw: _Turn
    aim_x: _Offset
    aim_y: _Offset


class _CameraSd(_Model):
    """Standard deviations of the same."""

    x: _LengthSd
    y: _LengthSd
    distance: _LengthSd
    tilt_x: _TurnSd
    tilt_y: _TurnSd
    yaw: _TurnSd
    aim_x: _LengthSd
    aim_y: _LengthSd


class HandFile(_Model):
    """A hand file."""

    format: Literal["stretch-hand/1"]
    source: str = Field(min_length=1, description="which command or person measured it, on which cell, when")
    camera: _Camera
    camera_sd: _CameraSd
    gripper: GripperCalibration | None = None
    gripper_sd: _LengthSd | None = Field(
        default=None, description="standard deviation of its largest opening, against the first"
    )


def written(fields: Mapping[str, Any]) -> str:
    """Return the text of a file from the fields that `calibrate-hand` prints, SI."""
    provenance = fields["provenance"]
    told = fields["residuals"]["told"]
    when = f"{provenance['made']}, {provenance['frames']} frames at {len(told)} openings"
    # quoted, because files may be named anything
    source = json.dumps(f"stretch-bt calibrate-hand {provenance['cell']}, {when}")
    lines = [f"format: {FORMAT}", f"source: {source}"]
    for key, part in (("camera", "value"), ("camera_sd", "sd")):
        lines.append(f"{key}:")
        lines += [f"  {name}: {_quantity(name, e[part])}" for name, e in fields["camera"].items()]
    points = fields["gripper"]["points"]
    if points:
        lines += ["gripper:", "  points:"]
        lines += [f"    - {{count: {p['count']}, opening: {1e3 * p['opening']:.3f} mm}}" for p in points]
        lines += [f"  source: {source}", f"gripper_sd: {1e3 * max(p['sd'] for p in points):.3f} mm"]
    return "\n".join(lines) + "\n"


def _quantity(name: str, value: float) -> str:
    if name in TURNS:
        return f"{math.degrees(value):.5f} deg"
    return f"{1e3 * value:.4f} mm"
