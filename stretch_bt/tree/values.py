"""Literal values of a file, read by the type that is wanted: units, whole numbers, options, bounds."""

from __future__ import annotations

import math
from typing import Any, NoReturn

from stretch_bt.errors import Diagnostic, InvalidInput, StretchError
from stretch_bt.source import Mark, Scalar, Seq, Value, did_you_mean
from stretch_bt.tree.types import Family, Type
from stretch_bt.units import format_quantity, parse_quantity, unit_names

__all__ = ["Refused", "check_bounds", "literal", "written"]


class Refused(StretchError):
    """A piece of a file is wrong; `.diagnostic` says where and why."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(str(diagnostic))


def refuse(mark: Mark, code: str, message: str, hint: str = "") -> NoReturn:
    """Raise Refused with an error at this place."""
    raise Refused(mark.error(code, message, hint))


def literal(value: Value, type_: Type, what: str) -> Any:
    """Return the SI or plain value that a literal stands for; `what` names it in messages."""
    if type_.family is Family.LIST:
        return _list(value, type_, what)
    if not isinstance(value, Scalar):
        refuse(value.mark, "type-mismatch", f"{what} takes {type_}, not a list or mapping", _example(type_))
    if type_.family is Family.QUANTITY:
        return _quantity(value, type_, what)
    if type_.family is Family.ENUM:
        if value.text not in type_.options:
            refuse(
                value.mark,
                "option-unknown",
                f"{what} takes {type_}, not {value.text!r}",
                did_you_mean(value.text, type_.options),
            )
        return value.text
    if type_.family is Family.STR:
        return value.text
    if type_.family is Family.OBJECT:
        refuse(value.mark, "type-mismatch", f"{what} takes {type_}, which has no literal form", "give it a $key")
    return _plain(value, type_, what)


def written(value: Value) -> str:
    """Return a value as a file has it, on one line."""
    if isinstance(value, Scalar):
        return " ".join(value.text.split())
    if isinstance(value, Seq):
        return f"[{', '.join(written(item) for item in value.items)}]"
    return f"{{{', '.join(f'{key.text}: {written(item)}' for key, item in value)}}}"


def _plain(value: Scalar, type_: Type, what: str) -> Any:
    given = value.value
    if type_.family is Family.BOOL and isinstance(given, bool):
        return given
    if type_.family is Family.INT and isinstance(given, int) and not isinstance(given, bool):
        return given
    if type_.family is Family.FLOAT:
        if isinstance(given, int | float) and not isinstance(given, bool) and math.isfinite(given):
            return float(given)
        if isinstance(given, str) and given.rstrip().endswith("%"):
            return _percent(value, what)
    refuse(value.mark, "type-mismatch", f"{what} takes {type_}, not {value.text!r}", _example(type_))


def _percent(value: Scalar, what: str) -> float:
    try:
        return parse_quantity(value.text)[0]
    except InvalidInput:
        refuse(value.mark, "type-mismatch", f"{what} takes a number, not {value.text!r}", "write it as in '5 %'")


def _quantity(value: Scalar, type_: Type, what: str) -> float:
    try:
        number, dimension = parse_quantity(value.text)
    except InvalidInput:
        unit = type_.kind.unit if type_.kind else unit_names(type_.dimension)[0]
        refuse(
            value.mark,
            "type-mismatch",
            f"{what} takes {type_}, not {value.text!r}",
            f"write a number and a unit, as in '10 {unit}'",
        )
    if dimension == type_.dimension:
        return number
    unit = type_.kind.unit if type_.kind else ""
    if not any(dimension):
        refuse(value.mark, "unit-missing", f"{what}: {value.text} has no unit", f"write '{value.text.strip()} {unit}'")
    hint = f"use one of {', '.join(unit_names(type_.dimension))}"
    refuse(value.mark, "unit-mismatch", f"{what} takes {type_}, but {value.text!r} is {dimension}", hint)


def _list(value: Value, type_: Type, what: str) -> list[Any]:
    assert type_.item is not None
    if not isinstance(value, Seq):
        refuse(value.mark, "type-mismatch", f"{what} takes {type_}", f"write it as in [{_sample(type_.item)}, ...]")
    return [literal(item, type_.item, what) for item in value.items]


def _sample(type_: Type) -> str:
    if type_.kind is not None:
        return f"10 {type_.kind.unit}"
    samples = {Family.BOOL: "true", Family.INT: "3", Family.FLOAT: "0.5", Family.STR: "text"}
    return samples.get(type_.family, type_.options[0] if type_.options else "$key")


def _example(type_: Type) -> str:
    return f"write it as in {_sample(type_)!r}"


def check_bounds(value: Any, type_: Type, low: float | None, high: float | None, mark: Mark, what: str) -> None:
    """Raise Refused when a number, or an item of a list, lies outside its bounds (both ends allowed)."""
    if isinstance(value, list):
        for item in value:
            check_bounds(item, type_.item or type_, low, high, mark, what)
        return
    if not type_.is_number:
        return
    if (low is None or value >= low * (1 - 1e-12)) and (high is None or value <= high * (1 + 1e-12)):
        return

    def show(number: float) -> str:
        return format_quantity(number, type_.dimension)

    ends = f"{show(low) if low is not None else '...'} to {show(high) if high is not None else '...'}"
    nearest = high if high is not None and value > high else low
    assert nearest is not None
    refuse(
        mark,
        "out-of-bounds",
        f"{what}: {show(value)} is outside {ends}",
        f"the nearest allowed value is {show(nearest)}",
    )
