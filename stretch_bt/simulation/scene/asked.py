"""Tolerances that a run asks for, in the place of its scene's."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import ValidationError

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.plain_numbers import is_number, plain_number
from stretch_bt.simulation.scene.sections import Tolerance
from stretch_bt.source import did_you_mean
from stretch_bt.units import DIMENSIONLESS, KINDS, parse_quantity

__all__ = ["LENGTHS", "asked_pairs", "read_asked"]

#: results whose tolerance is a length; other tolerances are a part of the result
LENGTHS = ("height", "size")
_OPTION = "--tolerance"


def asked_pairs(texts: Iterable[str]) -> dict[str, str]:
    """Return the tolerances of a command line, NAME=P each, by name.

    Raises
    ------
    InvalidInput
        A text without a name or a value, or a name that comes twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (equals and name and value):
            raise InvalidInput(f"{_OPTION} takes NAME=P, not {text!r}; write {_OPTION} stiffness=2%")
        if name in found:
            raise InvalidInput(f"{_OPTION} {name} is given twice; leave one of them out")
        found[name] = value
    return found


def read_asked(given: Mapping[str, Any]) -> Tolerance:
    """Return the tolerance that a run asks for: by the name of a result text such as `0.3 mm` or `2 %`, or an SI number.

    Raises
    ------
    InvalidInput
        Nothing is named, there is no such result, or its tolerance is none: a percentage of a length, a length of a part, or out of
        bounds.
    """
    values = {name: _value(name, plain_number(value)) for name, value in given.items()}
    try:
        return Tolerance.model_validate({name: _written(name, value) for name, value in values.items()})
    except ValidationError as error:
        told = error.errors()[0]
        where = f"{_OPTION} {told['loc'][0]}" if told["loc"] else _OPTION
        message = str(told.get("ctx", {}).get("error") or told["msg"])
        raise InvalidInput(f"{where}: {message.removeprefix('Value error, ')}") from None


def _value(name: str, given: object) -> float:
    """Return one tolerance, SI."""
    if name not in Tolerance.model_fields:
        hint = did_you_mean(name, Tolerance.model_fields) or "name height, size, force, stiffness or roundness"
        raise InvalidInput(f"{_OPTION}: there is no result {name!r}; {hint}")
    if is_number(given):
        return float(given)
    example = f"write {_OPTION} {name}={'0.3mm' if name in LENGTHS else '2%'}"
    wanted = "a length" if name in LENGTHS else "a percentage"
    try:
        value, dimension = parse_quantity(str(given))
    except InvalidInput:
        raise InvalidInput(f"{_OPTION} {name} takes {wanted}, not {shown(given)[:80]}; {example}") from None
    fits = dimension == (KINDS["Length"].dimension if name in LENGTHS else DIMENSIONLESS)
    if not fits or (name not in LENGTHS and not str(given).strip().endswith("%")):
        raise InvalidInput(f"{_OPTION} {name} takes {wanted}, not {shown(given)[:80]}; {example}")
    return value


def _written(name: str, value: float) -> str | float:
    """Return a tolerance as a scene takes it."""
    return f"{value!r} m" if name in LENGTHS else value
