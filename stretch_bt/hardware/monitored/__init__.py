"""Every device as nodes see it: a driver under ownership, limits, ages, latched faults and a journal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

from stretch_bt.hardware.monitored.arm import MonitoredArm
from stretch_bt.hardware.monitored.base import Monitored, Watch
from stretch_bt.hardware.monitored.camera import MonitoredCamera
from stretch_bt.hardware.monitored.force_sensor import MonitoredForceSensor
from stretch_bt.hardware.monitored.gripper import MonitoredGripper
from stretch_bt.hardware.monitored.operator import MonitoredOperator

__all__ = ["MONITORED", "Monitored", "Watch", "arms_first"]

_Device = TypeVar("_Device")

MONITORED: dict[str, type[Monitored[Any]]] = {
    "Arm": MonitoredArm,
    "Gripper": MonitoredGripper,
    "DepthCamera": MonitoredCamera,
    "ForceSensor": MonitoredForceSensor,
    "Operator": MonitoredOperator,
}


def arms_first(devices: Iterable[_Device]) -> list[_Device]:
    """Return devices in the order in which they are stopped: an arm first, as another one may take its time."""
    return sorted(devices, key=lambda device: not isinstance(device, MonitoredArm))
