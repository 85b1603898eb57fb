"""What a value must be to be written to a port: its type, finite, within the bounds, its deviation not negative."""

from __future__ import annotations

import dataclasses
import math
import sys
import types
import typing
from functools import lru_cache
from numbers import Integral, Real
from typing import Annotated, Any

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.plain_numbers import is_number, plain_list, plain_number
from stretch_bt.tree.types import ANY, Family, Type, annotations_of, from_annotation
from stretch_bt.tree.values import outside, within
from stretch_bt.units import Estimate, parse_quantity

__all__ = ["PortCheck", "allows_none"]

_LARGEST = sys.float_info.max
_PLAIN = {Family.BOOL: bool, Family.INT: int, Family.FLOAT: float, Family.QUANTITY: float, Family.STR: str}
_SAID = {
    Family.BOOL: "True or False",
    Family.INT: "an int",
    Family.FLOAT: "a finite number",
    Family.STR: "a str",
}


class PortCheck:
    """Judges the values of one port; `optional` allows None.

    `exact`, `low` and `high` let a caller pass a plain number within its bounds without a call.
    """

    __slots__ = ("bounds", "exact", "high", "low", "optional", "type")

    def __init__(self, annotation: Any, low: float | None, high: float | None) -> None:
        self.type = _type_of(annotation)
        self.optional = allows_none(annotation)
        self.bounds = (low, high)
        # the numbers of a record are looked at
        self.exact = _PLAIN.get(self.type.family, None if dataclasses.is_dataclass(self.type.cls) else self.type.cls)
        self.low: float = -_LARGEST if low is None else low
        self.high: float = _LARGEST if high is None else high

    def judge(self, value: Any) -> Any:
        """Return the value with numpy's numbers made plain and tuples made lists; raises InvalidInput, which says what was expected."""
        if type(value) is Estimate and self.exact is float and self.low <= value <= self.high and _fits(value.sd):
            return value  # as what follows finds too, in a tenth of the time
        return None if value is None and self.optional else self._fit(value, self.type)

    def expected(self) -> str:
        """Return what the port takes, in words."""
        return _expected(self.type) + (" or None" if self.optional else "")

    def _fit(self, value: Any, type_: Type) -> Any:
        if type_.family is Family.ANY:
            return value
        if type_.family is Family.LIST:
            return self._list(value, type_)
        if type_.is_number:
            return self._number(value, type_)
        if type_.family is Family.BOOL and _is_truth(value):
            return bool(value)
        if type_.members:
            return self._member(value, type_)
        plain_text = isinstance(value, str) and type_.family in (Family.STR, Family.ENUM)
        if plain_text and (not type_.options or value in type_.options):
            return value
        if type_.cls is not None and _is_one(value, type_.cls):
            return _with_right_numbers(value)
        raise InvalidInput(self._refusal(value))

    def _member(self, value: Any, type_: Type) -> Any:
        value = plain_number(value)
        for member in type_.members:
            if type(value) is type(member) and value == member:  # True is not 1 here
                return value
        raise InvalidInput(self._refusal(value))

    def _list(self, value: Any, type_: Type) -> Any:
        value = plain_list(value)
        if not isinstance(value, list | tuple) or type_.item is None:
            raise InvalidInput(self._refusal(value))
        return [self._fit(item, type_.item) for item in value]  # which a tuple is told as, and saved as, too

    def _number(self, value: Any, type_: Type) -> Any:
        wanted = Integral if type_.family is Family.INT else Real
        if isinstance(value, bool) or not isinstance(value, wanted):
            raise InvalidInput(self._refusal(value))
        if not is_number(value):
            raise InvalidInput(f"{self._refusal(value)}; raise NoAnswer where there is none")
        number: Any = value if isinstance(value, Estimate) else _PLAIN[type_.family](value)
        if isinstance(number, Estimate) and not _fits(number.sd):
            raise InvalidInput(f"its standard deviation is {number.sd!r}; it takes a finite one that is not negative")
        if not within(number, *self.bounds):
            raise InvalidInput(outside(number, type_, *self.bounds))
        return number

    def _refusal(self, value: Any) -> str:
        hint = _as_si(value, self.type)
        return f"it takes {self.expected()}, not {_short(value)}{hint and '; ' + hint}"


@lru_cache(maxsize=256)
def _numbers_of(cls: type) -> tuple[tuple[str, bool, bool, float], ...]:
    """Return the fields of a record that are numbers: name, whether it is whole, whether it may be None, and the least that it may be.

    Of a class without fields of its own, as where a mock gives some of them, and of one whose annotations mean nothing here, none.
    """
    if "__dataclass_fields__" not in vars(cls):
        return ()
    try:
        hints = annotations_of(cls)
    except (NameError, TypeError):
        return ()
    names = {field.name for field in dataclasses.fields(cls)}
    found = []
    for name in names & hints.keys():
        type_ = _type_of(hints[name])
        least = 0.0 if name.endswith("_sd") and name.removesuffix("_sd") in names else -math.inf
        if type_.is_number:
            found.append((name, type_.family is Family.INT, allows_none(hints[name]), least))
    return tuple(found)


def _with_right_numbers(value: Any) -> Any:
    """Return a record, or whatever else it is; raises InvalidInput where a number of it is none."""
    cls: type = type(value)
    for name, whole, optional, least in _numbers_of(cls):
        given: Any = getattr(value, name, None)
        right = isinstance(given, Integral if whole else Real) and bool(least <= given)  # type: ignore[operator]  # which NaN is not
        if not right and not (given is None and (optional or not hasattr(value, name))):
            wanted = "a whole number" if whole else "a number" if least < 0 else "a number that is not negative"
            raise InvalidInput(
                f"its field {name!r} takes {wanted}{' or None' if optional else ''}, not {_short(given)}"
            )
    return value


def _fits(sd: float) -> bool:
    """Whether a standard deviation is finite and not negative."""
    return 0.0 <= sd <= _LARGEST


def _type_of(annotation: Any) -> Type:
    try:
        return from_annotation(annotation)
    except TypeError:  # such a node is not registered
        return ANY


def allows_none(annotation: Any) -> bool:
    """Whether an annotation, such as `Length | None`, has None among its values."""
    if typing.get_origin(annotation) is Annotated:
        return allows_none(typing.get_args(annotation)[0])
    union = typing.get_origin(annotation) in (typing.Union, types.UnionType)
    return annotation is Any or (union and type(None) in typing.get_args(annotation))


def _is_truth(value: Any) -> bool:
    if isinstance(value, bool):
        return True
    import numpy as np

    return isinstance(value, np.bool_)


def _is_one(value: Any, cls: type) -> bool:
    try:
        return isinstance(value, cls)
    except TypeError:  # a protocol that cannot be asked
        return True


def _expected(type_: Type) -> str:
    if type_.family is Family.QUANTITY:
        unit = type_.kind.si_unit if type_.kind else "SI"
        return f"a {type_.name} (a finite number, {unit})"
    if type_.family is Family.ENUM:
        return f"one of {', '.join(type_.options)}"
    if type_.item is not None:
        return f"a list, each {_expected(type_.item)}"
    return _SAID.get(type_.family, f"a {type_.name}")


def _as_si(value: Any, type_: Type) -> str:
    """Return what to write for text such as `5 mm`."""
    if not isinstance(value, str) or not type_.is_number:
        return ""
    try:
        number, dimension = parse_quantity(value)
    except InvalidInput:
        return ""
    return f"write {number:g}" if dimension == type_.dimension else ""


def _short(value: Any) -> str:
    text = shown(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
