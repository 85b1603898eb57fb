"""Every stand-in, by its name on the command line; imported when it is asked for."""

from __future__ import annotations

from importlib import import_module

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.emulators.base import StandIn

__all__ = ["STAND_INS", "stand_in_class"]

STAND_INS: dict[str, str] = {
    "ur": "stretch_bt.hardware.emulators.ur.stand_in:Ur5StandIn",
    "ur5e": "stretch_bt.hardware.emulators.ur.stand_in:Ur5eStandIn",
    "robotiq": "stretch_bt.hardware.emulators.robotiq:RobotiqStandIn",
    "urcap": "stretch_bt.hardware.emulators.urcap:UrcapStandIn",
    "ati": "stretch_bt.hardware.emulators.ati:AtiStandIn",
    "realsense": "stretch_bt.hardware.emulators.realsense:RealsenseStandIn",
}


def stand_in_class(name: str) -> type[StandIn]:
    """Return the stand-in behind a name; raises InvalidInput where there is none."""
    if name not in STAND_INS:
        raise InvalidInput(f"there is no stand-in {name!r}; there are {', '.join(STAND_INS)}")
    module, _, cls = STAND_INS[name].partition(":")
    found: type[StandIn] = getattr(import_module(module), cls)
    return found
