"""What no device could do, whatever its limits allow: numbers of commands that are none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.indenters import check_indenter

__all__ = ["check_asked", "check_speed"]


def check_asked(device: str, arguments: Mapping[str, Any]) -> None:
    """Raise InvalidInput for arguments of a command that make no sense, SI; a replay refuses them as the run did."""
    if "path" in arguments and not arguments["path"]:
        raise InvalidInput(f"{device}: a path needs at least one pose")
    if "opening" in arguments and not math.isfinite(arguments["opening"]):
        raise InvalidInput(f"{device}: opening must be finite, m, not {arguments['opening']}")
    if "speed" in arguments:
        check_speed(device, arguments["speed"])
    if "geometry" in arguments:
        check_indenter(arguments["geometry"], arguments["size"])


def check_speed(device: str, speed: float) -> None:
    """Raise InvalidInput unless a speed, m/s, is a finite number above 0."""
    if not (math.isfinite(speed) and speed > 0):
        raise InvalidInput(f"{device}: speed must be finite and above 0 m/s, not {speed}")
