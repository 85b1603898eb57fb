"""From a checked expression to a callable without arguments: closures over cells and readings, no Python evaluated."""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Callable
from typing import Any, Protocol

from stretch_bt.errors import Absent, InvalidInput
from stretch_bt.tree.expression.parse import EQUALITIES, Binary, Constant, Expression, FunctionCall, Name, Unary
from stretch_bt.tree.series import LIST_FUNCTIONS
from stretch_bt.tree.types import NONE, Family
from stretch_bt.units import Estimate

__all__ = ["Environment", "bind"]

Thunk = Callable[[], Any]

_BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
_ARITHMETIC = ("+", "-", "*", "/")
_LARGEST = sys.float_info.max
_FUNCTIONS: dict[str, Callable[..., Any]] = {"abs": abs, "min": min, "max": max, "sqrt": math.sqrt}


class Environment(Protocol):
    """Where the values of names come from in a run."""

    def source(self, parts: tuple[str, ...]) -> tuple[Thunk, tuple[str, ...]]:
        """Return what reads the name, and the attributes left to follow."""
        ...


def bind(expression: Expression, environment: Environment) -> Thunk:
    """Return a callable that evaluates the expression now."""
    if isinstance(expression, Constant):
        value = expression.value
        return lambda: value
    if isinstance(expression, Name):
        return _bind_name(expression, environment)
    if isinstance(expression, Unary):
        return _bind_unary(expression, bind(expression.operand, environment))
    if isinstance(expression, Binary):
        return _bind_binary(expression, bind(expression.left, environment), bind(expression.right, environment))
    assert isinstance(expression, FunctionCall)
    arguments = [bind(a, environment) for a in expression.arguments]
    if expression.arguments[0].type.item is not None:
        of_list = LIST_FUNCTIONS[expression.function]
        whole = expression.function == "sum" and expression.type.family is Family.INT
        return (lambda: int(of_list(arguments[0]()))) if whole else (lambda: of_list(*(a() for a in arguments)))
    function = _FUNCTIONS[expression.function]
    return lambda: _finite(expression.function, function, *(a() for a in arguments))


def _bind_name(name: Name, environment: Environment) -> Thunk:
    read, rest = environment.source(name.parts)
    if not rest:
        return read
    text = ".".join(name.parts)

    def follow() -> Any:
        value = read()
        for part in rest:
            value = _item(value, int(part), text) if part.isdigit() else getattr(value, part)
            if value is None:
                raise Absent(f"{text} is none")
        return value

    return follow


def _item(value: Any, index: int, text: str) -> Any:
    if index >= len(value):
        raise Absent(f"{text} has no value: the list holds {len(value)}")
    return value[index]


def _bind_unary(expression: Unary, operand: Thunk) -> Thunk:
    if expression.operator == "not":
        return lambda: not operand()
    return lambda: -operand()


def _bind_binary(expression: Binary, left: Thunk, right: Thunk) -> Thunk:
    if expression.operator == "and":
        return lambda: left() and right()
    if expression.operator == "or":
        return lambda: left() or right()
    function = _BINARY[expression.operator]
    if expression.operator in EQUALITIES:
        asks = NONE in (expression.left.type, expression.right.type)
        left, right = _compared(expression.left, left, asks), _compared(expression.right, right, asks)
    if expression.operator in _ARITHMETIC:
        return lambda: _finite(expression.operator, function, left(), right())
    return lambda: function(left(), right())


def _compared(side: Expression, read: Thunk, asks: bool) -> Thunk:
    """Return what gives a side of `==`: its value without its error; None for an absent name, or for anything absent where `none` `asks`."""
    plain = (lambda: _without_error(read())) if side.type.is_number and isinstance(side, Name | FunctionCall) else read
    return _or_none(plain) if asks or isinstance(side, Name) else plain


def _without_error(value: Any) -> Any:
    return float(value) if type(value) is Estimate else value


def _or_none(read: Thunk) -> Thunk:
    """Return a function that gives None where there is no value."""

    def maybe() -> Any:
        try:
            return read()
        except Absent:
            return None

    return maybe


def _finite(name: str, function: Callable[..., Any], *values: Any) -> Any:
    """Return a number; raises InvalidInput, with the calculation, where the result is none that a key could hold."""
    try:
        result = function(*values)
        if -_LARGEST <= result <= _LARGEST:
            return result
    except (ArithmeticError, ValueError):
        pass
    given = f" {name} ".join(map(str, values)) if name in _ARITHMETIC else f"{name}({', '.join(map(str, values))})"
    raise InvalidInput(f"{given} is no finite number; guard it with a comparison") from None
