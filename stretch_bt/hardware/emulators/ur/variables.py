"""What a controller tells and takes by RTDE: names, types and where the values are."""

from __future__ import annotations

from collections.abc import Callable

from stretch_bt.hardware.emulators.ur.controller import REGISTERS, Controller
from stretch_bt.hardware.emulators.ur.wire import Value

__all__ = ["INPUTS", "OUTPUTS", "Ask"]

_ZERO6, _ZERO3 = (0.0,) * 6, (0.0,) * 3
Ask = Callable[[Controller], Value]

#: by name: type, and how to ask for the value
OUTPUTS: dict[str, tuple[str, Ask]] = {
    "timestamp": ("DOUBLE", lambda c: c.time),
    "target_q": ("VECTOR6D", lambda c: tuple(c.arm.q)),
    "target_qd": ("VECTOR6D", lambda c: tuple(c.arm.qd)),
    "target_qdd": ("VECTOR6D", lambda c: _ZERO6),
    "target_current": ("VECTOR6D", lambda c: _ZERO6),
    "target_moment": ("VECTOR6D", lambda c: _ZERO6),
    "actual_q": ("VECTOR6D", lambda c: tuple(c.arm.q)),
    "actual_qd": ("VECTOR6D", lambda c: tuple(c.arm.qd)),
    "actual_qdd": ("VECTOR6D", lambda c: _ZERO6),
    "actual_current": ("VECTOR6D", lambda c: _ZERO6),
    "joint_control_output": ("VECTOR6D", lambda c: _ZERO6),
    "actual_TCP_pose": ("VECTOR6D", lambda c: c.arm.tcp_pose),
    "actual_TCP_speed": ("VECTOR6D", lambda c: c.arm.tcp_speed),
    "actual_TCP_force": ("VECTOR6D", lambda c: c.force()),
    "target_TCP_pose": ("VECTOR6D", lambda c: c.arm.tcp_pose),
    "target_TCP_speed": ("VECTOR6D", lambda c: c.arm.tcp_speed),
    "actual_digital_input_bits": ("UINT64", lambda c: 0),
    "joint_temperatures": ("VECTOR6D", lambda c: (30.0,) * 6),
    "actual_execution_time": ("DOUBLE", lambda c: 0.0002),
    "robot_mode": ("INT32", lambda c: c.robot_mode),
    "joint_mode": ("VECTOR6INT32", lambda c: (253 if c.powered else 239,) * 6),
    "safety_mode": ("INT32", lambda c: c.safety.mode),
    "actual_tool_accelerometer": ("VECTOR3D", lambda c: _ZERO3),
    "speed_scaling": ("DOUBLE", lambda c: c.speed_fraction),
    "target_speed_fraction": ("DOUBLE", lambda c: c.speed_fraction),
    "actual_momentum": ("DOUBLE", lambda c: 0.0),
    "actual_main_voltage": ("DOUBLE", lambda c: 48.0),
    "actual_robot_voltage": ("DOUBLE", lambda c: 48.0 if c.powered else 0.0),
    "actual_robot_current": ("DOUBLE", lambda c: 0.5),
    "actual_joint_voltage": ("VECTOR6D", lambda c: (48.0,) * 6),
    "actual_digital_output_bits": ("UINT64", lambda c: c.digital_outputs),
    "runtime_state": ("UINT32", lambda c: c.runtime_state),
    "standard_analog_input0": ("DOUBLE", lambda c: 0.0),
    "standard_analog_input1": ("DOUBLE", lambda c: 0.0),
    "standard_analog_output0": ("DOUBLE", lambda c: 0.0),
    "standard_analog_output1": ("DOUBLE", lambda c: 0.0),
    "robot_status_bits": ("UINT32", lambda c: c.status_bits),
    "safety_status_bits": ("UINT32", lambda c: c.safety.bits),
    "ft_raw_wrench": ("VECTOR6D", lambda c: c.force()),
    "payload": ("DOUBLE", lambda c: c.payload),
    "payload_cog": ("VECTOR3D", lambda c: _ZERO3),
    "payload_inertia": ("VECTOR6D", lambda c: _ZERO6),
    "output_bit_registers0_to_31": ("UINT32", lambda c: 0),
    "output_bit_registers32_to_63": ("UINT32", lambda c: 0),
}


def _registers() -> None:
    def integer(k: int) -> Ask:
        return lambda c: c.registers.out_int[k]

    def double(k: int) -> Ask:
        return lambda c: c.registers.out_double[k]

    for k in range(REGISTERS):
        OUTPUTS[f"output_int_register_{k}"] = ("INT32", integer(k))
        OUTPUTS[f"output_double_register_{k}"] = ("DOUBLE", double(k))


_registers()

INPUTS: dict[str, str] = {
    "speed_slider_mask": "UINT32",
    "speed_slider_fraction": "DOUBLE",
    "standard_digital_output_mask": "UINT8",
    "standard_digital_output": "UINT8",
    "configurable_digital_output_mask": "UINT8",
    "configurable_digital_output": "UINT8",
    "tool_digital_output_mask": "UINT8",
    "tool_digital_output": "UINT8",
    "standard_analog_output_mask": "UINT8",
    "standard_analog_output_type": "UINT8",
    "standard_analog_output_0": "DOUBLE",
    "standard_analog_output_1": "DOUBLE",
    "external_force_torque": "VECTOR6D",
    **{f"input_int_register_{k}": "INT32" for k in range(REGISTERS)},
    **{f"input_double_register_{k}": "DOUBLE" for k in range(REGISTERS)},
}
