"""Every field of RTDE by name: its type, and the software that has it first. By the maker's guide to "Real-Time Data Exchange".

Where the guide names no version, a field is taken to be in all. Registers up to 23 and bits up to 63 are meant for a fieldbus, the
ones above for clients of RTDE; both are served alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

__all__ = ["BITS", "INPUT_FIELDS", "OUTPUT_FIELDS", "REGISTERS", "Field", "found"]

#: general purpose registers of each kind and direction, and bits of each direction
REGISTERS, BITS = 48, 128
#: bits that have a field each; the ones before come in two words
_SINGLE = range(64, BITS)

Version = tuple[int, int] | None


class Field(NamedTuple):
    """Type of a field, and the first software that has it: of a CB3 and of an e-series, None where none has."""

    kind: str
    cb3: Version = (3, 0)
    e_series: Version = (5, 0)

    def is_in(self, version: tuple[int, ...]) -> bool:
        """Whether a controller with this software, (major, minor, ...), has the field."""
        first = self.cb3 if version[0] < 5 else self.e_series
        return first is not None and version >= first


_UPPER = (3, 9), (5, 3)


def _registers(direction: str) -> dict[str, Field]:
    """Return the fields of all general purpose registers of a direction, "input" or "output"."""
    made = {
        f"{direction}_bit_registers0_to_31": Field("UINT32"),
        f"{direction}_bit_registers32_to_63": Field("UINT32"),
    }
    made |= {f"{direction}_bit_register_{k}": Field("BOOL", *_UPPER) for k in _SINGLE}
    for name, kind in (("int", "INT32"), ("double", "DOUBLE")):
        for k in range(REGISTERS):
            made[f"{direction}_{name}_register_{k}"] = Field(kind, *(_UPPER if k > 23 else ()))
    return made


OUTPUT_FIELDS: Mapping[str, Field] = {
    "timestamp": Field("DOUBLE"),
    "target_q": Field("VECTOR6D"),
    "target_qd": Field("VECTOR6D"),
    "target_qdd": Field("VECTOR6D"),
    "target_current": Field("VECTOR6D"),
    "target_moment": Field("VECTOR6D"),
    "actual_q": Field("VECTOR6D"),
    "actual_qd": Field("VECTOR6D"),
    "actual_qdd": Field("VECTOR6D"),
    "actual_current": Field("VECTOR6D"),
    "actual_current_window": Field("VECTOR6D"),
    "actual_current_as_torque": Field("VECTOR6D", None, (5, 23)),
    "joint_control_output": Field("VECTOR6D"),
    "actual_TCP_pose": Field("VECTOR6D"),
    "actual_TCP_speed": Field("VECTOR6D"),
    "actual_TCP_force": Field("VECTOR6D"),
    "actual_TCP_acceleration": Field("VECTOR6D", None, (5, 23)),
    "target_TCP_pose": Field("VECTOR6D"),
    "target_TCP_speed": Field("VECTOR6D"),
    "target_TCP_acceleration": Field("VECTOR6D", None, (5, 23)),
    "actual_digital_input_bits": Field("UINT64"),
    "actual_configurable_digital_input_bits": Field("UINT64"),
    "joint_temperatures": Field("VECTOR6D"),
    "actual_execution_time": Field("DOUBLE"),
    "target_execution_time": Field("DOUBLE", None, (5, 23)),
    "robot_mode": Field("INT32"),
    "joint_mode": Field("VECTOR6INT32"),
    "safety_mode": Field("INT32"),
    "safety_status": Field("INT32", (3, 10), (5, 4)),
    "actual_tool_accelerometer": Field("VECTOR3D"),
    "speed_scaling": Field("DOUBLE"),
    "target_speed_fraction": Field("DOUBLE"),
    "actual_momentum": Field("DOUBLE"),
    "actual_main_voltage": Field("DOUBLE"),
    "actual_robot_voltage": Field("DOUBLE"),
    "actual_robot_current": Field("DOUBLE"),
    "actual_robot_energy_consumed": Field("DOUBLE", None, (5, 23)),
    "actual_robot_braking_energy_dissipated": Field("DOUBLE", None, (5, 23)),
    "actual_joint_voltage": Field("VECTOR6D"),
    "actual_digital_output_bits": Field("UINT64"),
    "actual_configurable_digital_output_bits": Field("UINT64"),
    "runtime_state": Field("UINT32"),
    "elbow_position": Field("VECTOR3D", (3, 5)),
    "elbow_velocity": Field("VECTOR3D", (3, 5)),
    "robot_status_bits": Field("UINT32"),
    "safety_status_bits": Field("UINT32"),
    "analog_io_types": Field("UINT32"),
    "standard_analog_input0": Field("DOUBLE"),
    "standard_analog_input1": Field("DOUBLE"),
    "standard_analog_output0": Field("DOUBLE"),
    "standard_analog_output1": Field("DOUBLE"),
    "io_current": Field("DOUBLE"),
    "euromap67_input_bits": Field("UINT32"),
    "euromap67_output_bits": Field("UINT32"),
    "euromap67_24V_voltage": Field("DOUBLE"),
    "euromap67_24V_current": Field("DOUBLE"),
    "tool_mode": Field("UINT32"),
    "tool_analog_input_types": Field("UINT32"),
    "tool_analog_input0": Field("DOUBLE"),
    "tool_analog_input1": Field("DOUBLE"),
    "tool_output_voltage": Field("INT32"),
    "tool_output_current": Field("DOUBLE"),
    "tool_temperature": Field("DOUBLE"),
    "tool_output_mode": Field("UINT8", None, (5, 2)),
    "tool_digital_output0_mode": Field("UINT8", None, (5, 2)),
    "tool_digital_output1_mode": Field("UINT8", None, (5, 2)),
    "tcp_force_scalar": Field("DOUBLE"),
    "tcp_offset": Field("VECTOR6D", (3, 11), (5, 5)),
    "payload": Field("DOUBLE", (3, 11), (5, 5)),
    "payload_cog": Field("VECTOR3D", (3, 11), (5, 5)),
    "payload_inertia": Field("VECTOR6D", (3, 15), (5, 11)),
    "script_control_line": Field("UINT32", (3, 14), (5, 9)),
    "ft_raw_wrench": Field("VECTOR6D", None, (5, 9)),
    "wrench_calc_from_currents": Field("VECTOR6D", None, (5, 23)),
    "joint_position_deviation_ratio": Field("DOUBLE"),
    "collision_detection_ratio": Field("DOUBLE", None, (5, 15)),
    "time_scale_source": Field("INT32", None, (5, 17)),
    "encoder0_raw": Field("INT32"),
    "encoder1_raw": Field("INT32"),
    "target_gravity": Field("VECTOR3D", None, (5, 23)),
    "target_base_acceleration": Field("VECTOR6D", None, (5, 23)),
    "target_base_wrench": Field("VECTOR6D", None, (5, 23)),
    "control_step": Field("UINT64", None, (5, 23)),
    **_registers("output"),
    **_registers("input"),
}

INPUT_FIELDS: Mapping[str, Field] = {
    "speed_slider_mask": Field("UINT32"),
    "speed_slider_fraction": Field("DOUBLE"),
    "standard_digital_output_mask": Field("UINT8"),
    "standard_digital_output": Field("UINT8"),
    "configurable_digital_output_mask": Field("UINT8"),
    "configurable_digital_output": Field("UINT8"),
    "tool_digital_output_mask": Field("UINT8"),
    "tool_digital_output": Field("UINT8"),
    "standard_analog_output_mask": Field("UINT8"),
    "standard_analog_output_type": Field("UINT8"),
    "standard_analog_output_0": Field("DOUBLE"),
    "standard_analog_output_1": Field("DOUBLE"),
    "external_force_torque": Field("VECTOR6D", (3, 3)),
    **_registers("input"),
}


def found(fields: Mapping[str, Field], name: str, version: tuple[int, ...]) -> Field | None:
    """Return a field by its name, None where a controller with this software has none of that name."""
    field = fields.get(name)
    return field if field is not None and field.is_in(version) else None
