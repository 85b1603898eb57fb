"""Names and units of an expression, checked before anything runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from stretch_bt.errors import Absent, StretchError
from stretch_bt.source import did_you_mean
from stretch_bt.tree.expression.parse import (
    EQUALITIES,
    Binary,
    Constant,
    Expression,
    ExpressionError,
    FunctionCall,
    Name,
    Unary,
)
from stretch_bt.tree.series import LIST_FUNCTIONS
from stretch_bt.tree.types import BOOL, FLOAT, INT, NONE, Family, Type, attributes, quantity
from stretch_bt.units import DIMENSIONLESS, unit_names

__all__ = ["Origin", "Scope", "Symbol", "Unresolved", "names", "typecheck"]


class Origin(Enum):
    """Where the value of a name comes from."""

    KEY = "key"
    SD = "standard deviation of a key"
    PARAM = "param"
    READING = "reading of a device"
    TASK = "task"


@dataclass(frozen=True, slots=True)
class Symbol:
    """What a name means: `used` parts of the dotted name give it, the rest are attributes; constants carry a value."""

    origin: Origin
    name: str
    type: Type
    used: int
    value: object = None

    def read(self) -> object:
        """Return the value of a constant; raises Absent where it is none."""
        if self.value is None:
            raise Absent(f"{self.name} is none")
        return self.value


class Unresolved(StretchError):
    """A dotted name means nothing: `at` counts the part that is not known, `hint` says what to write."""

    def __init__(self, at: int, hint: str) -> None:
        self.at, self.hint = at, hint
        super().__init__(hint)


class Scope(Protocol):
    """Where names are looked up."""

    def resolve(self, parts: tuple[str, ...]) -> Symbol:
        """Return the symbol of a dotted name; raises Unresolved when there is none."""
        ...


def names(expression: Expression) -> Iterator[Name]:
    """Yield every name in an expression, from left to right."""
    if isinstance(expression, Name):
        yield expression
    elif isinstance(expression, Unary):
        yield from names(expression.operand)
    elif isinstance(expression, Binary):
        yield from names(expression.left)
        yield from names(expression.right)
    elif isinstance(expression, FunctionCall):
        for argument in expression.arguments:
            yield from names(argument)


def typecheck(expression: Expression, scope: Scope) -> Type:
    """Fill in and return the type; raises ExpressionError at the part that is wrong."""
    expression.type = _infer(expression, scope)
    return expression.type


def _infer(expression: Expression, scope: Scope) -> Type:
    if isinstance(expression, Constant):
        return expression.type
    if isinstance(expression, Name):
        return _name(expression, scope)
    if isinstance(expression, Unary):
        return _unary(expression, typecheck(expression.operand, scope))
    if isinstance(expression, Binary):
        left, right = typecheck(expression.left, scope), typecheck(expression.right, scope)
        return _binary(expression, left, right)
    assert isinstance(expression, FunctionCall)
    return _call(expression, [typecheck(a, scope) for a in expression.arguments])


def _name(name: Name, scope: Scope) -> Type:
    try:
        symbol = scope.resolve(name.parts)
    except Unresolved as unknown:
        message = f"{'.'.join(name.parts)!r} is not known here"
        offset, length = _part(name, unknown.at)
        raise ExpressionError(offset, length, "name-unknown", message, unknown.hint) from None
    return follow(name, symbol.type, symbol.used)


def _part(name: Name, at: int) -> tuple[int, int]:
    """Return offset and length of a part of a dotted name; the first one has the dollar, if there is any."""
    if at >= len(name.parts):
        return name.offset, name.length
    dollar = name.length - len(".".join(name.parts))
    if at == 0:
        return name.offset, dollar + len(name.parts[0])
    return name.offset + dollar + len(".".join(name.parts[:at])) + 1, len(name.parts[at])


def follow(name: Name, type_: Type, used: int) -> Type:
    """Return the type of the attributes and items after the `used` first parts; raises ExpressionError at a wrong one."""
    for at, part in enumerate(name.parts[used:], used):
        if type_.family is Family.LIST and type_.item is not None and part.isdigit():
            type_ = type_.item
            continue
        known = attributes(type_.cls) if type_.cls is not None else {}
        if part not in known:
            hint = did_you_mean(part, known) if known else _of_no_parts(name, at, type_)
            offset, length = _part(name, at)
            raise ExpressionError(offset, length, "attribute-unknown", f"{type_} has no {part!r}", hint)
        type_ = known[part]
    return type_


def _of_no_parts(name: Name, at: int, type_: Type) -> str:
    """Return what to write in place of a part that a value without parts does not have."""
    if type_.family is not Family.LIST:
        return f"remove it: a {type_} has no parts"
    whole = ".".join(name.parts[:at])
    return f"'len({whole})' is the number of entries, '{whole}.0' the first"


def _unary(expression: Unary, operand: Type) -> Type:
    if expression.operator == "not":
        _need_bool(expression.operand, operand)
        return BOOL
    _need_number(expression.operand, operand)
    return operand


def _binary(expression: Binary, left: Type, right: Type) -> Type:
    operator = expression.operator
    if operator in ("and", "or"):
        _need_bool(expression.left, left)
        _need_bool(expression.right, right)
        return BOOL
    if operator in EQUALITIES and NONE in (left, right):
        return BOOL
    if operator in EQUALITIES and not left.is_number:
        if not (left.accepts(right) or right.accepts(left) or _same_text(left, right)):
            raise _error(expression, "type-mismatch", f"{left} is compared with {right}", "compare values of one type")
        _known_option(expression, left, right)
        return BOOL
    _need_number(expression.left, left)
    _need_number(expression.right, right)
    if operator in ("*", "/"):
        dimension = left.dimension.times(right.dimension, 1 if operator == "*" else -1)
        whole = operator == "*" and left.family is right.family is Family.INT
        return INT if whole else quantity(dimension)
    _same_dimension(expression, left, right)
    if operator in ("+", "-"):
        return INT if left.family is right.family is Family.INT else quantity(left.dimension)
    return BOOL


def _same_text(left: Type, right: Type) -> bool:
    return {left.family, right.family} <= {Family.STR, Family.ENUM}


def _known_option(expression: Binary, left: Type, right: Type) -> None:
    for type_, other in ((left, expression.right), (right, expression.left)):
        if type_.family is Family.ENUM and isinstance(other, Constant) and other.value not in type_.options:
            hint = did_you_mean(str(other.value), type_.options)
            raise _error(other, "option-unknown", f"{other.value!r} is none of {type_}", hint)


def _call(expression: FunctionCall, arguments: list[Type]) -> Type:
    if expression.function in LIST_FUNCTIONS and len(arguments) <= 1 + (expression.function == "at"):
        return _of_list(expression, arguments)
    for argument, type_ in zip(expression.arguments, arguments, strict=True):
        _need_number(argument, type_)
        if type_.dimension != arguments[0].dimension:
            raise _units(argument, arguments[0], type_)
    if expression.function == "sqrt":
        dimension = arguments[0].dimension
        if any(e % 2 for e in dimension):
            raise _error(expression, "unit-mismatch", f"the square root of {dimension} has no unit", "multiply first")
        return quantity(type(dimension)(*(e // 2 for e in dimension)))
    return arguments[0] if all(a == arguments[0] for a in arguments) else quantity(arguments[0].dimension)


def _of_list(expression: FunctionCall, arguments: list[Type]) -> Type:
    """Return the type of what a function makes of a list."""
    function, item = expression.function, arguments[0].item
    if item is None:
        message = f"{function}() of one value takes a list, not {arguments[0]}"
        hint = (
            "give it two values or more"
            if function in ("min", "max")
            else "use a list, as 'collect' of a loop makes one"
        )
        raise _error(expression.arguments[0], "type-mismatch", message, hint)
    if function not in ("len", "at") and not item.is_number:
        raise _error(
            expression.arguments[0], "type-mismatch", f"{function}() takes numbers, not {item}", "use 'len' or 'at'"
        )
    if function == "at" and arguments[1].family is not Family.INT:
        raise _error(
            expression.arguments[1],
            "type-mismatch",
            f"at() counts with an int, not {arguments[1]}",
            "write 'at(list, 0)'",
        )
    if function in ("len", "argmin"):
        return INT
    if function == "sort":
        return arguments[0]
    return FLOAT if function in ("mean", "median") and item is INT else item


def _same_dimension(expression: Binary, left: Type, right: Type) -> None:
    if left.dimension == right.dimension:
        return
    plain = next((e for e, t in ((expression.left, left), (expression.right, right)) if t in (INT, FLOAT)), None)
    other = right if plain is expression.left else left
    if isinstance(plain, Constant) and other.dimension != DIMENSIONLESS:
        unit = other.kind.unit if other.kind else " or ".join(unit_names(other.dimension))
        raise _error(plain, "unit-missing", f"{plain.value} has no unit", f"write '{plain.value} {unit}'")
    if isinstance(expression.right, Constant) != isinstance(expression.left, Constant):
        on_right = isinstance(expression.right, Constant)
        at, other = (expression.right, left) if on_right else (expression.left, right)
        units = ", ".join(unit_names(other.dimension))
        advice = f"use one of {units}" if any(other.dimension) else "write it without a unit"
        message = f"{left} and {right} do not go together"
        raise _error(at, "unit-mismatch", message, f"the other side is {other}: {advice}")
    raise _units(expression, left, right)


def _units(at: Expression, left: Type, right: Type) -> ExpressionError:
    return _error(at, "unit-mismatch", f"{left} and {right} do not go together", "use values of one dimension")


def _need_number(at: Expression, type_: Type) -> None:
    if not type_.is_number:
        raise _error(at, "type-mismatch", f"a number is needed here, not {type_}", "use a number or a quantity")


def _need_bool(at: Expression, type_: Type) -> None:
    if type_.family is not Family.BOOL:
        raise _error(at, "type-mismatch", f"true or false is needed here, not {type_}", "compare it with something")


def _error(at: Expression, code: str, message: str, hint: str) -> ExpressionError:
    return ExpressionError(at.offset, at.length, code, message, hint)
