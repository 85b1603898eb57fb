"""The packet of the real-time port, by the maker's guide to "Client interfaces": doubles after one size in four bytes, big-endian."""

from __future__ import annotations

import struct

from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.variables import OUTPUTS

__all__ = ["realtime_packet"]

#: name of each field in RTDE; a number stands for that many zeros, reserved or not simulated
_FIELDS: tuple[str | int, ...] = (
    "timestamp",
    "target_q",
    "target_qd",
    "target_qdd",
    "target_current",
    "target_moment",
    "actual_q",
    "actual_qd",
    "actual_current",
    "joint_control_output",
    "actual_TCP_pose",
    "actual_TCP_speed",
    "actual_TCP_force",
    "target_TCP_pose",
    "target_TCP_speed",
    "actual_digital_input_bits",
    "joint_temperatures",
    "actual_execution_time",
    1,
    "robot_mode",
    "joint_mode",
    "safety_mode",
    6,
    "actual_tool_accelerometer",
    6,
    "speed_scaling",
    "actual_momentum",
    2,
    "actual_main_voltage",
    "actual_robot_voltage",
    "actual_robot_current",
    "actual_joint_voltage",
    "actual_digital_output_bits",
    "runtime_state",
    "elbow_position",
    "elbow_velocity",
    "safety_status",
)
#: further fields of e-series controllers from 5.10 on
_LATER: tuple[str | int, ...] = (3, "payload", "payload_cog", "payload_inertia")


def realtime_packet(controller: Controller) -> bytes:
    """Return the packet of this cycle: 1116 bytes of a CB3, 1220 of an e-series."""
    fields = _FIELDS + _LATER if controller.profile.e_series else _FIELDS
    numbers: list[float] = []
    for field in fields:
        value = (0.0,) * field if isinstance(field, int) else OUTPUTS[field](controller)
        numbers.extend(value if isinstance(value, tuple) else (value,))
    return struct.pack(f">i{len(numbers)}d", 4 + 8 * len(numbers), *numbers)
