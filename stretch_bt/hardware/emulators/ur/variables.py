"""The values of RTDE's output fields: asked of the controller where its model knows them, else the values of an idle robot."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.fields import BITS, OUTPUT_FIELDS, REGISTERS
from stretch_bt.hardware.emulators.ur.wire import Value
from stretch_bt.hardware.transforms import six

__all__ = ["OUTPUTS", "Ask"]

Ask = Callable[[Controller], Value]

_GRAVITY = 9.82
_ZERO = {"VECTOR3D": (0.0,) * 3, "VECTOR6D": (0.0,) * 6, "VECTOR6INT32": (0,) * 6, "DOUBLE": 0.0, "BOOL": False}
#: an idle robot's values of what is not simulated; the rest is zero
_IDLE: dict[str, Value] = {
    "joint_temperatures": (30.0,) * 6,
    "actual_execution_time": 0.0002,
    "actual_main_voltage": 48.0,
    "actual_robot_current": 0.5,
    "io_current": 0.02,
    "tool_temperature": 30.0,
    "tool_digital_output0_mode": 1,
    "tool_digital_output1_mode": 1,
    "target_gravity": (0.0, 0.0, _GRAVITY),
}

#: by name, how to ask for what the model knows
_KNOWN: dict[str, Ask] = {
    "timestamp": lambda c: c.time,
    "target_q": lambda c: tuple(c.arm.q),
    "target_qd": lambda c: tuple(c.arm.qd),
    "actual_q": lambda c: tuple(c.arm.q),
    "actual_qd": lambda c: tuple(c.arm.qd),
    "actual_TCP_pose": lambda c: c.arm.tcp_pose,
    "actual_TCP_speed": lambda c: c.arm.tcp_speed,
    "actual_TCP_force": lambda c: c.force(),
    "target_TCP_pose": lambda c: c.arm.tcp_pose,
    "target_TCP_speed": lambda c: c.arm.tcp_speed,
    "robot_mode": lambda c: c.robot_mode,
    "joint_mode": lambda c: (c.joint_mode,) * 6,
    "safety_mode": lambda c: c.safety.mode,
    "safety_status": lambda c: c.safety.mode,
    "actual_tool_accelerometer": lambda c: tuple((_GRAVITY * c.arm.pose()[2, :3]).tolist()),
    "speed_scaling": lambda c: c.speed_fraction,
    "target_speed_fraction": lambda c: c.speed_fraction,
    "actual_robot_voltage": lambda c: 48.0 if c.powered else 0.0,
    "actual_joint_voltage": lambda c: (48.0 if c.powered else 0.0,) * 6,
    "actual_digital_output_bits": lambda c: c.digital_outputs,
    "actual_configurable_digital_output_bits": lambda c: c.digital_outputs >> 8 & 0xFF,
    "runtime_state": lambda c: c.runtime_state,
    "elbow_position": lambda c: tuple(_elbow(c)[:3]),
    "elbow_velocity": lambda c: tuple(_elbow(c)[3:]),
    "robot_status_bits": lambda c: c.status_bits,
    "safety_status_bits": lambda c: c.safety.bits,
    "analog_io_types": lambda c: c.analog.types << 2 | 0b11,
    "standard_analog_output0": lambda c: c.analog.outputs[0],
    "standard_analog_output1": lambda c: c.analog.outputs[1],
    "tool_mode": lambda c: c.tool_mode,
    "tcp_force_scalar": lambda c: math.hypot(*c.force()[:3]),
    "tcp_offset": lambda c: tuple(six(c.arm.tcp)),
    "payload": lambda c: c.payload,
    "payload_cog": lambda c: c.payload_cog,
    "payload_inertia": lambda c: c.payload_inertia,
    "script_control_line": lambda c: c.script_line,
    "ft_raw_wrench": lambda c: c.raw_force(),
    "control_step": lambda c: round(c.time * c.profile.rate),
}


def _elbow(controller: Controller) -> list[float]:
    """Return where the elbow is, m, and its velocity, m/s, in the base."""
    frames = controller.arm.frames()
    elbow = frames[2, :3, 3]
    if not controller.arm.qd.any():
        return [*elbow.tolist(), 0.0, 0.0, 0.0]
    turning = [np.cross(frame[:3, 2], elbow - frame[:3, 3]) for frame in frames[:2]]
    speed = turning[0] * controller.arm.qd[0] + turning[1] * controller.arm.qd[1]
    return [*elbow.tolist(), *speed.tolist()]


def _word(direction: str, first: int) -> Ask:
    return lambda c: sum(bit << k for k, bit in enumerate(c.registers.bits[direction][first : first + 32]))


def _bit(direction: str, k: int) -> Ask:
    return lambda c: c.registers.bits[direction][k]


def _registers() -> dict[str, Ask]:
    """Return how to ask for each general purpose register."""
    made: dict[str, Ask] = {}
    for direction, ints, doubles in (("input", _in_int, _in_double), ("output", _out_int, _out_double)):
        made[f"{direction}_bit_registers0_to_31"] = _word(direction, 0)
        made[f"{direction}_bit_registers32_to_63"] = _word(direction, 32)
        made |= {f"{direction}_bit_register_{k}": _bit(direction, k) for k in range(64, BITS)}
        made |= {f"{direction}_int_register_{k}": ints(k) for k in range(REGISTERS)}
        made |= {f"{direction}_double_register_{k}": doubles(k) for k in range(REGISTERS)}
    return made


def _in_int(k: int) -> Ask:
    return lambda c: c.registers.in_int[k]


def _in_double(k: int) -> Ask:
    return lambda c: c.registers.in_double[k]


def _out_int(k: int) -> Ask:
    return lambda c: c.registers.out_int[k]


def _out_double(k: int) -> Ask:
    return lambda c: c.registers.out_double[k]


def _constant(value: Value) -> Ask:
    return lambda c: value


_ASKED = {**_KNOWN, **_registers()}

#: by name of an output field, how to ask for its value
OUTPUTS: dict[str, Ask] = {
    name: _ASKED.get(name) or _constant(_IDLE.get(name, _ZERO.get(field.kind, 0)))
    for name, field in OUTPUT_FIELDS.items()
}
