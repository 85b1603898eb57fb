"""Messages of the primary and secondary ports, by the maker's guide to "Client interfaces": state of the robot, version, events.

All numbers are big-endian; a message begins with its size in four bytes, itself included, and its type in one, and so do the parts of
a state. What is not simulated is as on an idle robot.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.transforms import six

__all__ = ["key_message", "robot_state", "runtime_exception", "text_message", "version_message"]

_STATE, _MESSAGE = 16, 20
_TEXT, _VERSION, _KEY, _EXCEPTION = 0, 3, 7, 10
#: sources of messages: the controller itself and the program that runs
_CONTROLLER, _PROGRAM = -2, 7
_BUILD_DATE = b"01-01-2023, 00:00:00"
#: data sheets of both models: joints turn two times either way, at most at 180 deg/s
_TURN, _FASTEST, _ACCELERATION = 2 * math.pi, math.pi, 40.0
_ROBOT_TYPE = 1
#: values of a calibration that is the nominal one
_CHECKSUM, _CALIBRATED = (1, 2, 3, 4, 5, 6), 2


def version_message(controller: Controller) -> bytes:
    """Return what the controller says of its software to a client that connects."""
    major, minor, bugfix, build = controller.profile.version
    name = b"URControl"
    body = struct.pack(f">B{len(name)}sBBii", len(name), name, major, minor, bugfix, build)
    return _message(controller, _CONTROLLER, _VERSION, body + _BUILD_DATE)


def text_message(controller: Controller, text: str) -> bytes:
    """Return the message of a program's `textmsg`."""
    return _message(controller, _PROGRAM, _TEXT, text.encode())


def key_message(controller: Controller, title: str, text: str) -> bytes:
    """Return the message of an event in the life of a program, as its start or end."""
    body = struct.pack(">iiB", 0, 0, len(title)) + title.encode() + text.encode()
    return _message(controller, _PROGRAM, _KEY, body)


def runtime_exception(controller: Controller, line: int, column: int, text: str) -> bytes:
    """Return the message of a program that cannot be read or cannot go on, with the place in it, from 1."""
    return _message(controller, _PROGRAM, _EXCEPTION, struct.pack(">ii", line, column) + text.encode())


def _message(controller: Controller, source: int, kind: int, body: bytes) -> bytes:
    return _sized(_MESSAGE, struct.pack(">Qbb", _stamp(controller), source, kind) + body)


def robot_state(controller: Controller) -> bytes:
    """Return the state of the robot, with the parts that the controller's model has."""
    e_series = controller.profile.e_series
    parts = [_sized(kind, part(controller)) for kind, (newer, part) in _PARTS.items() if e_series or not newer]
    return _sized(_STATE, b"".join(parts))


def _sized(kind: int, body: bytes) -> bytes:
    return struct.pack(">iB", 5 + len(body), kind) + body


def _stamp(controller: Controller) -> int:
    """Return the controller's time, µs."""
    return round(controller.time * 1e6)


def _robot_mode(c: Controller) -> bytes:
    stopped = c.safety.mode
    flags = [True, True, c.powered, stopped == 7, stopped == 3, c.running, c.paused]
    made = struct.pack(">Q7?BBddd", _stamp(c), *flags, c.robot_mode, 0, c.speed_fraction, c.speed_fraction, 1.0)
    return made + b"\0" * c.profile.e_series


def _joints(c: Controller) -> bytes:
    volts = 48.0 if c.powered else 0.0
    rest = [0.0, volts, 30.0, 0.0, c.joint_mode]
    return b"".join(struct.pack(">ddd4fB", q, q, qd, *rest) for q, qd in zip(c.arm.q, c.arm.qd, strict=True))


def _tool(c: Controller) -> bytes:
    return struct.pack(">BBddfBffB", 0, 0, 0.0, 0.0, 48.0 if c.powered else 0.0, 0, 0.0, 30.0, c.tool_mode)


def _masterboard(c: Controller) -> bytes:
    inputs = struct.pack(">iiBBdd", 0, c.digital_outputs & 0x7FFFFFFF, 1, 1, 0.0, 0.0)
    outputs = struct.pack(">BBdd", c.analog.types & 1, c.analog.types >> 1 & 1, *c.analog.outputs)
    supply = struct.pack(">ffff", 30.0, 48.0 if c.powered else 0.0, 0.5, 0.02)
    safety = struct.pack(">BBBIBBB", c.safety.mode, 0, 0, 0, 0, 0, 0)
    return inputs + outputs + supply + safety


def _cartesian(c: Controller) -> bytes:
    return struct.pack(">12d", *c.arm.tcp_pose, *six(c.arm.tcp))


def _kinematics(c: Controller) -> bytes:
    known = c.arm.kinematics
    numbers = [*(0.0,) * 6, *known.a, *known.d, *known.alpha]
    return struct.pack(">6I24dI", *_CHECKSUM, *numbers, _CALIBRATED)


def _configuration(c: Controller) -> bytes:
    known = c.arm.kinematics
    limits = [*(-_TURN, _TURN) * 6, *(_FASTEST, _ACCELERATION) * 6]
    defaults = [1.05, 1.4, 0.25, 1.2, 0.2]
    numbers = [*limits, *defaults, *known.a, *known.d, *known.alpha, *(0.0,) * 6]
    box = 2 + c.profile.e_series
    return struct.pack(">53d4i", *numbers, 0, box, _ROBOT_TYPE, 0)


def _force_mode(c: Controller) -> bytes:
    return struct.pack(">7d", *c.force(), 0.0)


def _additional(c: Controller) -> bytes:
    return struct.pack(">3?", False, True, False) + b"\0" * c.profile.e_series


def _calibration(c: Controller) -> bytes:
    return struct.pack(">6d", *(0.0,) * 6)


def _tool_communication(c: Controller) -> bytes:
    return struct.pack(">?iiiff", False, 115200, 0, 1, 1.5, 3.5)


def _tool_mode(c: Controller) -> bytes:
    return struct.pack(">BBB", 0, 1, 1)


#: by type of a part: whether only newer controllers have it, and what is in it
_PARTS: dict[int, tuple[bool, Callable[[Controller], bytes]]] = {
    0: (False, _robot_mode),
    1: (False, _joints),
    2: (False, _tool),
    3: (False, _masterboard),
    4: (False, _cartesian),
    5: (False, _kinematics),
    6: (False, _configuration),
    7: (False, _force_mode),
    8: (False, _additional),
    9: (False, _calibration),
    11: (True, _tool_communication),
    12: (True, _tool_mode),
}
