"""Quantities as text for people, in the unit that each kind is shown in."""

from __future__ import annotations

from collections.abc import Callable

from stretch_bt.units import Dimension, Kind, kind_of

__all__ = ["digits_apart", "format_apart", "format_duration", "format_quantity"]


def format_quantity(value: float, kind: Kind | Dimension | None, digits: int = 4) -> str:
    """Return text such as `10 mm`, in the unit that the kind is shown in."""
    if isinstance(kind, Dimension):
        kind = kind_of(kind)
    if kind is None:
        return f"{value:.{digits}g}"
    return f"{value / kind.scale:.{digits}g} {kind.unit}"


def format_duration(seconds: float) -> str:
    """Return text such as `90 s`, `10 min` or `2 h`: in the longest unit of which it is a whole number."""
    for unit, length in (("h", 3600.0), ("min", 60.0)):
        if seconds >= length and seconds % length == 0:
            return f"{seconds / length:g} {unit}"
    return f"{seconds:g} s"


def format_apart(kind: Kind, value: float, *bounds: float) -> list[str]:
    """Return a value and the bounds that it is past as text, SI in, with as many digits as tell it from each of them."""
    digits = digits_apart(lambda number, digits: format_quantity(number, kind, digits), value, *bounds)
    return [format_quantity(number, kind, digits) for number in (value, *bounds)]


def digits_apart(show: Callable[[float, int], str], value: float, *others: float) -> int:
    """Return the fewest digits, from 4 on, with which `show` tells a value from others; 4 where it is one of them."""
    return next((d for d in range(4, 18) if show(value, d) not in [show(other, d) for other in others]), 4)
