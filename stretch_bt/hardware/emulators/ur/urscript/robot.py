"""Functions of URScript that ask the controller or set something, at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.emulators.ur.controller import Controller, ProgramEnded
from stretch_bt.hardware.emulators.ur.urscript.functions import pose_from
from stretch_bt.hardware.emulators.ur.urscript.values import Pose, Value, checked, place_of, six_of
from stretch_bt.hardware.transforms import transform

__all__ = ["robot_functions"]

#: where the groups of digital outputs begin, and how many each has
_GROUPS = {"": (0, 10), "standard_": (0, 8), "configurable_": (8, 8), "tool_": (16, 2)}
#: `set_digital_out` counts the two outputs of the tool after the eight standard ones
_TOOL_FIRST, _SHIFT = 8, 8


def robot_functions(controller: Controller, say: Callable[[str], None]) -> Mapping[str, Callable[..., Value]]:
    """Return the functions by name; `say` takes the text of a message."""
    c, arm = controller, controller.arm
    made: dict[str, Callable[..., Value]] = {
        "textmsg": lambda *words: say("".join(map(str, words))),
        "popup": lambda text="", *_, **__: say(str(text)),
        "get_actual_joint_positions": lambda: arm.q.tolist(),
        "get_target_joint_positions": lambda: arm.q.tolist(),
        "get_actual_joint_speeds": lambda: arm.qd.tolist(),
        "get_target_joint_speeds": lambda: arm.qd.tolist(),
        "get_actual_tcp_pose": lambda: Pose(arm.tcp_pose),
        "get_target_tcp_pose": lambda: Pose(arm.tcp_pose),
        "get_actual_tcp_speed": lambda: Pose(arm.tcp_speed),
        "get_actual_tool_flange_pose": lambda: pose_from(arm.frames()[6]),
        "get_tcp_force": lambda: list(c.force()),
        "force": lambda: math.hypot(*c.force()[:3]),
        "get_tcp_offset": lambda: pose_from(arm.tcp),
        "get_steptime": lambda: 1.0 / c.profile.rate,
        "is_steady": lambda: arm.steady,
        "get_forward_kin": lambda q=None, tcp=None: _forward(c, q, tcp),
        "get_inverse_kin": lambda pose, near=None, *_, **__: _joints(c, pose, near),
        "zero_ftsensor": c.zero_force,
        "set_tcp": lambda pose: _set_tcp(c, pose),
        "set_payload": lambda mass, cog=None: _set_payload(c, mass, cog),
        "set_payload_mass": lambda mass: _set_payload(c, mass, None),
        "set_payload_cog": lambda cog: _set_payload(c, c.payload, cog),
        "set_gravity": lambda direction: None,
        "set_tool_voltage": lambda voltage: None,
        "enter_critical": lambda: None,
        "exit_critical": lambda: None,
        "powerdown": lambda: _power_down(c),
    }
    for group, (first, count) in _GROUPS.items():
        made[f"set_{group}digital_out"] = _setting(c, first, count)
        made[f"get_{group}digital_out"] = _asking(c, first, count)
        made[f"get_{group}digital_in"] = lambda n: False
    return made | _registers(c)


def _registers(c: Controller) -> dict[str, Callable[..., Value]]:
    """Return what reads and writes the general purpose registers."""
    made: dict[str, Callable[..., Value]] = {}
    known: dict[str, tuple[list[Value], list[Value]]] = {
        "boolean": (c.registers.bits["input"], c.registers.bits["output"]),
        "integer": (c.registers.in_int, c.registers.out_int),
        "float": (c.registers.in_double, c.registers.out_double),
    }
    for kind, (inputs, outputs) in known.items():
        made[f"read_input_{kind}_register"] = _reading(inputs)
        made[f"read_output_{kind}_register"] = _reading(outputs)
        made[f"write_output_{kind}_register"] = _writing(outputs)
    return made


def _reading(registers: list[Value]) -> Callable[[int], Value]:
    def read(address: int) -> Value:
        return registers[place_of(address)]

    return read


def _writing(registers: list[Value]) -> Callable[[int, Value], None]:
    def write(address: int, value: Value) -> None:
        place = place_of(address)
        registers[place] = checked(type(registers[place])(value))

    return write


def _bit(first: int, count: int, number: int) -> int:
    if not 0 <= number < count:
        raise IndexError(f"there is no output {number}")
    return first + number + (_SHIFT if count > _TOOL_FIRST and number >= _TOOL_FIRST else 0)


def _setting(c: Controller, first: int, count: int) -> Callable[[int, bool], None]:
    def write(n: int, b: bool) -> None:
        bit = 1 << _bit(first, count, n)
        c.digital_outputs = c.digital_outputs & ~bit | (bit if b else 0)

    return write


def _asking(c: Controller, first: int, count: int) -> Callable[[int], bool]:
    return lambda n: bool(c.digital_outputs >> _bit(first, count, n) & 1)


def _forward(c: Controller, q: Value, tcp: Value) -> Pose:
    joints = c.arm.q if q is None else six_of(q)
    tool = c.arm.tcp if tcp is None else transform(six_of(tcp))
    return pose_from(c.arm.kinematics.forward(joints) @ tool)


def _joints(c: Controller, pose: Value, near: Value) -> list[float]:
    if c.shown("no_solution") is not None:
        raise IllConditioned("get_inverse_kin: no solution")
    found: list[float] = c.arm.joints_for(transform(six_of(pose)), None if near is None else six_of(near)).tolist()
    return found


def _set_tcp(c: Controller, pose: Value) -> None:
    c.arm.tcp = transform(six_of(pose))


def _set_payload(c: Controller, mass: float, cog: Value) -> None:
    c.payload = float(mass)
    if cog is not None:
        x, y, z = cog
        c.payload_cog = (float(x), float(y), float(z))


def _power_down(c: Controller) -> None:
    c.power(on=False)
    raise ProgramEnded
