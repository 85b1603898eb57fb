"""Every device as nodes see it: a driver under ownership, limits, ages, latched faults and a journal."""

from __future__ import annotations

from typing import Any

from stretch_bt.hardware.monitored.arm import MonitoredArm
from stretch_bt.hardware.monitored.base import Monitored, Watch
from stretch_bt.hardware.monitored.camera import MonitoredCamera
from stretch_bt.hardware.monitored.force_sensor import MonitoredForceSensor
from stretch_bt.hardware.monitored.gripper import MonitoredGripper
from stretch_bt.hardware.monitored.operator import MonitoredOperator

__all__ = ["MONITORED", "Monitored", "Watch"]

MONITORED: dict[str, type[Monitored[Any]]] = {
    "Arm": MonitoredArm,
    "Gripper": MonitoredGripper,
    "DepthCamera": MonitoredCamera,
    "ForceSensor": MonitoredForceSensor,
    "Operator": MonitoredOperator,
}
