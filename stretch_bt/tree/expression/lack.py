"""Whether an expression may have no value."""

from __future__ import annotations

from collections.abc import Container

from stretch_bt.tree.expression.parse import EQUALITIES, Binary, Constant, Expression, FunctionCall, Name, Unary
from stretch_bt.tree.types import NONE

__all__ = ["may_lack"]

#: functions that have a value for every list, also for an empty one
_ALWAYS = ("len", "sum", "sort")


def may_lack(expression: Expression, absent: Container[str]) -> bool:
    """Whether an expression reads what may be `none`, where keys of these names may, or asks a list for what it may not hold."""
    if isinstance(expression, Constant):
        return False
    if isinstance(expression, Name):
        name, *fields = expression.parts
        return name in absent or name.removesuffix("_sd") in absent or (bool(fields) and name != "task")
    if isinstance(expression, Unary):
        return may_lack(expression.operand, absent)
    if isinstance(expression, Binary):
        sides: tuple[Expression, ...] = (expression.left, expression.right)
        if (
            expression.operator in EQUALITIES
        ):  # that a name is none is an answer, and so is all else where it is asked for
            asks = any(side.type == NONE for side in sides)
            sides = tuple(side for side in sides if not (asks or isinstance(side, Name)))
        return any(may_lack(side, absent) for side in sides)
    assert isinstance(expression, FunctionCall)
    of_list = expression.arguments[0].type.item is not None
    return (of_list and expression.function not in _ALWAYS) or any(may_lack(a, absent) for a in expression.arguments)
