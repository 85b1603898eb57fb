"""Functions of URScript that touch no robot: numbers, strings, lists and poses."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from stretch_bt.hardware.emulators.ur.urscript.values import Pose, Value, six_of
from stretch_bt.hardware.transforms import Array, inverse, rotation_vector, six, transform

__all__ = ["FUNCTIONS", "pose_from"]


def pose_from(matrix: Array) -> Pose:
    """Return the pose of a (4, 4) transform."""
    return Pose(six(matrix))


def _pose_trans(one: Value, other: Value) -> Pose:
    return pose_from(transform(six_of(one)) @ transform(six_of(other)))


def _pose_add(one: Value, other: Value) -> Pose:
    a, b = transform(six_of(one)), transform(six_of(other))
    made = a @ b
    made[:3, 3] = a[:3, 3] + b[:3, 3]
    return pose_from(made)


def _pose_sub(one: Value, other: Value) -> Pose:
    a, b = transform(six_of(one)), transform(six_of(other))
    made = a @ inverse(b)
    made[:3, 3] = a[:3, 3] - b[:3, 3]
    return pose_from(made)


def _between(one: Value, other: Value, part: float) -> Pose:
    a, b = transform(six_of(one)), transform(six_of(other))
    made = np.eye(4)
    made[:3, 3] = a[:3, 3] + part * (b[:3, 3] - a[:3, 3])
    turn = rotation_vector(a[:3, :3].T @ b[:3, :3])
    made[:3, :3] = a[:3, :3] @ transform([0.0, 0.0, 0.0, *(part * turn)])[:3, :3]
    return pose_from(made)


def _distance(one: Value, other: Value) -> float:
    return math.dist(six_of(one)[:3], six_of(other)[:3])


def _text(value: Value) -> str:
    if isinstance(value, list):
        return ("p" if isinstance(value, Pose) else "") + "[" + ", ".join(map(_text, value)) + "]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _norm(value: Value) -> float:
    return math.hypot(*value) if isinstance(value, list) else abs(value)


FUNCTIONS: Mapping[str, Callable[..., Value]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "pow")},
    "floor": math.floor,
    "ceil": math.ceil,
    "log": lambda base, value: math.log(value, base),
    "d2r": math.radians,
    "r2d": math.degrees,
    "norm": _norm,
    "length": len,
    "get_list_length": len,
    "to_str": _text,
    "str_cat": lambda one, other: _text(one) + _text(other),
    "str_len": len,
    "pose_trans": _pose_trans,
    "pose_inv": lambda pose: pose_from(inverse(transform(six_of(pose)))),
    "pose_add": _pose_add,
    "pose_sub": _pose_sub,
    "pose_dist": _distance,
    "point_dist": _distance,
    "interpolate_pose": _between,
    "integer_to_binary_list": lambda value: [bool(value >> k & 1) for k in range(32)],
}
