"""Literal values of a file, read by the type that is wanted: units, whole numbers, options, bounds."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

from stretch_bt.errors import Diagnostic, InvalidInput, StretchError
from stretch_bt.quantity_text import digits_apart, format_quantity
from stretch_bt.source import TRUTHS, Map, Mark, Scalar, Seq, Value, did_you_mean
from stretch_bt.tree.types import BOOL, FLOAT, INT, STR, UNKNOWN, Family, Type, joined, list_of, quantity
from stretch_bt.units import KINDS, NUMBER, parse_quantity, parse_unit, suggest_quantity, unit_names, without_unit

#: a number with whatever people write after it for a unit; anything else that is not plain YAML is an expression
_LITERAL = re.compile(
    rf"\s*(?:{NUMBER}|[-+]?[0-9][0-9.,:]*)\s*(?:[^\W\d_][\w/%^²³]*|[%°]|(?<![0-9.])1/[A-Za-z]\w*)?\s*|\s*[-+]?\.(?:inf|nan)\s*",
    re.IGNORECASE,
)

#: text that is no number and yet has a unit, from which the quantity is known
_NO_NUMBER = re.compile(r"\s*[-+]?\.?(?:nan|inf|infinity)\s*([^\W\d_]\S*)\s*", re.IGNORECASE)

#: a name as it stands in text
NAMED = re.compile(r"\$[A-Za-z_]\w*(?:\.\w+)*", re.ASCII)

__all__ = [
    "NAMED",
    "ValueRefused",
    "braces",
    "check_bounds",
    "example",
    "is_none",
    "literal",
    "literal_type",
    "outside",
    "reads_as_expression",
    "sample",
    "within",
    "written",
    "written_pairs",
]


class ValueRefused(StretchError):
    """A piece of a file is wrong; `.diagnostic` says where and why, and `.others` are further mistakes in it."""

    def __init__(self, diagnostic: Diagnostic, *others: Diagnostic) -> None:
        self.diagnostic = diagnostic
        self.others = others
        super().__init__(str(diagnostic))


def refuse(mark: Mark, code: str, message: str, hint: str = "") -> NoReturn:
    """Raise ValueRefused with an error at this place."""
    raise ValueRefused(mark.error(code, message, hint))


def reads_as_expression(value: Scalar) -> bool:
    """Whether a scalar that may be either is an expression: anything but a number, with or without a unit, and plain YAML."""
    if value.text.startswith("$"):
        return True
    if not value.text or _LITERAL.fullmatch(value.text):
        return False
    return isinstance(value.value, str)


def is_none(value: Value) -> bool:
    """Whether a value is the word for absence."""
    return isinstance(value, Scalar) and value.text == "none" and not value.quoted


def literal_type(value: Value, of: Callable[[Scalar], Type | None] = lambda _: None) -> Type:
    """Return the type that a literal has by itself: `10 mm` a Length, `3` an int, `[1, 2]` a list of ints.

    The items of a list that do not go together take the type of the first quantity among them, or else number, so that the others are
    refused at their places. `of` gives the type of a scalar that is no literal, and None of any other.
    """
    if isinstance(value, Seq):
        return list_of(_shared([literal_type(item, of) for item in value.items]))
    if isinstance(value, Scalar) and (found := of(value)) is not None:
        return found
    if not isinstance(value, Scalar) or value.value is None:
        return UNKNOWN
    plain = {bool: BOOL, int: INT, float: FLOAT}.get(type(value.value))
    if plain is not None:
        return plain
    not_finite = _NO_NUMBER.fullmatch(value.text)
    try:
        return quantity(parse_unit(not_finite[1])[1] if not_finite else parse_quantity(value.text)[1])
    except InvalidInput:
        return STR


def _shared(types: list[Type]) -> Type:
    found: Type | None = types[0] if types else UNKNOWN
    for type_ in types[1:]:
        found = found and joined(found, type_)
    likely = sorted(types, key=lambda t: (t.family is not Family.QUANTITY, not t.is_number))
    return found or likely[0]


def literal(value: Value, type_: Type, what: str) -> Any:
    """Return the SI or plain value that a literal stands for; `what` names it in messages."""
    if type_.family is Family.ANY:
        return written(value)
    if type_.family is Family.LIST:
        return _list(value, type_, what)
    if not isinstance(value, Scalar):
        hint = braces(value) or example(type_)
        refuse(value.mark, "type-mismatch", f"{what} takes {type_}, not a list or mapping", hint)
    if not value.text and not value.quoted:
        refuse(value.mark, "value-missing", f"{what} has no value", example(type_))
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
        return type_.member(value.text)
    if type_.family is Family.STR:
        return value.text
    if type_.family is Family.OBJECT:
        refuse(value.mark, "type-mismatch", f"{what} takes {type_}, which has no literal form", example(type_))
    return _plain(value, type_, what)


def written(value: Value) -> str:
    """Return a value as a file has it, on one line."""
    if isinstance(value, Scalar):
        return " ".join(value.text.split())
    if isinstance(value, Seq):
        return f"[{', '.join(written(item) for item in value.items)}]"
    return f"{{{', '.join(f'{key.text}: {written(item)}' for key, item in value)}}}"


def written_pairs(pairs: Mapping[str, str]) -> str:
    """Return names with what a file has for each, on one line; a name with nothing stands alone."""
    return f"{{{', '.join(f'{name}: {text}' if text else name for name, text in pairs.items())}}}"


def braces(value: Value) -> str:
    """Return a hint for `{key}`, which other tools take for the value of a key and YAML for a mapping."""
    if isinstance(value, Map) and len(value.pairs) == 1:
        [(key, inner)] = value.pairs
        if isinstance(inner, Scalar) and not inner.text and not inner.quoted:
            return f"write '${key.text}'"
    return ""


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
    if value.quoted and Scalar(value.text, False, value.mark).value != value.text:
        refuse(
            value.mark, "type-mismatch", f"{what} takes {type_}, not text in quotes", f"remove the quotes: {value.text}"
        )
    truth = TRUTHS.get(value.text.lower()) if type_.family is Family.BOOL else None
    hint = f"write '{truth}'" if truth else example(type_)
    refuse(value.mark, "type-mismatch", f"{what} takes {type_}, not {value.text!r}", hint)


def _percent(value: Scalar, what: str) -> float:
    try:
        return parse_quantity(value.text)[0]
    except InvalidInput:
        refuse(value.mark, "type-mismatch", f"{what} takes a number, not {value.text!r}", "write it as in '5 %'")


def _quantity(value: Scalar, type_: Type, what: str) -> float:
    try:
        number, dimension = parse_quantity(value.text)
    except InvalidInput as error:
        hint = suggest_quantity(value.text, type_.dimension)
        code = "type-mismatch" if hint.startswith("write a number") else "unit-unknown"
        refuse(value.mark, code, f"{what} takes {type_}, and {error}", hint)
    if dimension == type_.dimension:
        return number
    unit = type_.kind.unit if type_.kind else ""
    if not any(dimension):
        message, hint = without_unit(value.text, type_.name, unit)
        refuse(value.mark, "unit-missing", f"{what}: {message}", hint)
    hint = f"use one of {', '.join(unit_names(type_.dimension))}"
    refuse(value.mark, "unit-mismatch", f"{what} takes {type_}, but {value.text!r} is {dimension}", hint)


def _list(value: Value, type_: Type, what: str) -> list[Any]:
    assert type_.item is not None
    if not isinstance(value, Seq):
        refuse(value.mark, "type-mismatch", f"{what} takes {type_}", f"write it as in [{sample(type_.item)}, ...]")
    return [literal(item, type_.item, what) for item in value.items]


def sample(type_: Type) -> str:
    """Return a value of a type, as a file may have it."""
    if type_.kind is not None:
        return f"10 {type_.kind.unit}"
    samples = {Family.BOOL: "true", Family.INT: "3", Family.FLOAT: "0.5", Family.STR: "text"}
    return samples.get(type_.family, type_.options[0] if type_.options else "$key")


def example(type_: Type) -> str:
    """Return a hint that shows a value of a type."""
    if type_.family is Family.BOOL:
        return "write 'true' or 'false'"
    if type_.family is Family.OBJECT:
        return f"give it a $key of type {type_}"
    if type_.family is Family.ENUM:
        return f"write one of {', '.join(type_.options)}"
    if type_.item is not None:
        return f"write it as in [{sample(type_.item)}]"
    what = {Family.INT: "a whole number, ", Family.QUANTITY: "a number and a unit, "}.get(type_.family, "it ")
    return f"write {what}as in {sample(type_)!r}"


def check_bounds(value: Any, type_: Type, low: float | None, high: float | None, mark: Mark, what: str) -> None:
    """Raise ValueRefused when a number, or an item of a list, lies outside its bounds (both ends allowed)."""
    if isinstance(value, list):
        for item in value:
            check_bounds(item, type_.item or type_, low, high, mark, what)
    elif type_.is_number and not within(value, low, high):
        refuse(mark, "out-of-bounds", f"{what}: {outside(value, type_, low, high)}", _allowed(value, type_, low, high))


def _allowed(value: float, type_: Type, low: float | None, high: float | None) -> str:
    """Return what to write for a number that is out of its bounds; whoever wrote a time wants one above 0."""
    nearest = _nearest(value, low, high)
    if type_.dimension == KINDS["Time"].dimension and low == 0 and high is None:
        return f"write a time above 0, as in {_show(-value, type_, _digits(value, nearest, type_))!r}"
    return f"write {_show(nearest, type_, _digits(value, nearest, type_))!r}, the nearest allowed value"


def within(value: float, low: float | None, high: float | None) -> bool:
    """Whether a number lies within its bounds, rounding aside."""
    return (low is None or value >= low - 1e-12 * abs(low)) and (high is None or value <= high + 1e-12 * abs(high))


def outside(value: float, type_: Type, low: float | None, high: float | None) -> str:
    """Return the message about a number that is out of its bounds: `50 mm is outside 0 mm to 30 mm`, or `-1 s is below 0 s`."""
    digits = _digits(value, _nearest(value, low, high), type_)
    given = _show(value, type_, digits)
    if low is not None and high is not None:
        return f"{given} is outside {_show(low, type_, digits)} to {_show(high, type_, digits)}"
    return f"{given} is {'above' if low is None else 'below'} {_show(_nearest(value, low, high), type_, digits)}"


def _nearest(value: float, low: float | None, high: float | None) -> float:
    nearest = high if high is not None and value > high else low
    assert nearest is not None
    return nearest


def _digits(value: float, nearest: float, type_: Type) -> int:
    """Return how many digits distinguish a number from its bound."""
    return digits_apart(lambda number, digits: _show(number, type_, digits), value, nearest)


def _show(number: float, type_: Type, digits: int) -> str:
    if type_.family is Family.INT:
        return str(int(number))
    return format_quantity(number, type_.dimension, digits)
