"""What no device could do, whatever its limits allow: numbers of commands that are none."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.frames import Pose
from stretch_bt.hardware.indenters import check_indenter
from stretch_bt.plain_numbers import is_number

__all__ = ["check_age", "check_asked", "check_speed"]


def check_asked(device: str, arguments: Mapping[str, Any]) -> None:
    """Raise InvalidInput for arguments of a command that make no sense, SI; a replay refuses them as the run did."""
    if "path" in arguments and not arguments["path"]:
        raise InvalidInput(f"{device}: a path needs at least one pose")
    for pose in (*arguments.get("path", ()), *([arguments["target"]] if "target" in arguments else ())):
        if not isinstance(pose, Pose):
            raise InvalidInput(f"{device}: it goes to a Pose, not to {shown(pose)}; write Pose((x, y, z)), in m")
    if "opening" in arguments and not is_number(arguments["opening"]):
        raise InvalidInput(f"{device}: opening must be a finite number, m, not {shown(arguments['opening'])}")
    if "speed" in arguments:
        check_speed(device, arguments["speed"])
    if "geometry" in arguments:
        check_indenter(arguments["geometry"], arguments["size"])


def check_speed(device: str, speed: float) -> None:
    """Raise InvalidInput unless a speed, m/s, is a finite number above 0."""
    if not (is_number(speed) and speed > 0):
        raise InvalidInput(f"{device}: speed must be finite and above 0 m/s, not {shown(speed)}")


def check_age(device: str, max_age: float) -> None:
    """Raise InvalidInput unless the age that a reading may have, s, is a finite number above 0."""
    if not (is_number(max_age) and max_age > 0):
        raise InvalidInput(f"{device}: max_age must be finite and above 0 s, not {shown(max_age)}")
