"""Values of URScript and what its signs do with them."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

__all__ = ["SIGNS", "Pose", "Value", "checked", "place_of", "six_of"]

Value = Any
_LARGEST, _LONGEST = 1 << 31, 10_000
#: no angle, length or speed of an arm is larger, in SI units
_FARTHEST = 1e4


class Pose(list[float]):
    """Six numbers in which a place is: m and a rotation vector, rad."""


def checked(value: Value) -> Value:
    """Return a value; raises ValueError for one that a controller has no room for."""
    if isinstance(value, int) and not -_LARGEST <= value < _LARGEST:
        raise ValueError("the number is too large")
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("the number is not finite")
    if isinstance(value, str | list) and len(value) > _LONGEST:
        raise ValueError("the list or string is too long")
    return value


def six_of(value: Value) -> list[float]:
    """Return six finite numbers; raises TypeError for anything else."""
    if not isinstance(value, Sequence) or len(value) != 6 or isinstance(value, str):
        raise TypeError("six numbers are expected")
    if not all(isinstance(v, int | float) and abs(v) < _FARTHEST for v in value):
        raise TypeError("six numbers of a possible size are expected")
    return [float(v) for v in value]


def place_of(value: Value) -> int:
    """Return which of a list's values is meant; raises IndexError for what is no place in a list."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise IndexError(f"{value!r} is no place in a list")
    return value


def _number(value: Value) -> float | int:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError("a number is expected")
    return value


def _truth(value: Value) -> bool:
    if not isinstance(value, bool):
        raise TypeError("True or False is expected")
    return value


def _of_numbers(sign: Callable[[Any, Any], Any]) -> Callable[[Value, Value], Value]:
    return lambda a, b: sign(_number(a), _number(b))


#: operators of two values; `and` and `or` do without the second where the first says it all
SIGNS: Mapping[str, Callable[[Value, Value], Value]] = {
    "+": _of_numbers(operator.add),
    "-": _of_numbers(operator.sub),
    "*": _of_numbers(operator.mul),
    "/": _of_numbers(operator.truediv),
    "%": _of_numbers(math.fmod),
    "<": _of_numbers(operator.lt),
    ">": _of_numbers(operator.gt),
    "<=": _of_numbers(operator.le),
    ">=": _of_numbers(operator.ge),
    "==": operator.eq,
    "!=": operator.ne,
    "and": lambda a, b: _truth(a) and _truth(b),
    "or": lambda a, b: _truth(a) or _truth(b),
    "xor": lambda a, b: _truth(a) is not _truth(b),
}
