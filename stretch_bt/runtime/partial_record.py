"""Records that a person writes by hand, all fields of them or some: in a mocks file, and as a mapping in a test."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from stretch_bt.brief import brief
from stretch_bt.errors import Diagnostic, InvalidInput, UnsetKey
from stretch_bt.runtime.mock_arrays import array_fields
from stretch_bt.source import Mark, did_you_mean
from stretch_bt.tree.types import Type, annotations_of, attributes
from stretch_bt.tree.values import ValueRefused, refuse

__all__ = ["FieldReader", "record_of"]

V = TypeVar("V")


@dataclass(frozen=True, slots=True)
class FieldReader(Generic[V]):
    """How fields are written by hand.

    Parameters
    ----------
    array
        Reads one that is an array, of a type where the class names it; given its name for messages. Raises ValueRefused.
    value
        Reads any other one; given its type, the annotation that it has in its class, and its name for messages. Raises ValueRefused.
    origin
        What messages call a record with some fields, as in `mocked {}`.
    remedy
        What to do where another field is read, as in `add it to the mock's outputs`; `{}` stands for its name.
    defaults
        Whether fields that were not given have the defaults of the class.
    """

    array: Callable[[V, np.dtype[Any] | None, str], Any]
    value: Callable[[V, Type, Any, str], Any]
    origin: str
    remedy: str
    defaults: bool = False


def record_of(cls: type, fields: Iterable[tuple[str, Mark, V]], what: str, mark: Mark, read: FieldReader[V]) -> Any:
    """Return a record of fields by their names, each with the place of its name.

    It is one of its class where these are all fields without a default, else one that says so where another field is read.

    Raises
    ------
    ValueRefused
        A name is no field, a field does not fit its type, or the class refuses the fields.
    """
    given: dict[str, Any] = {}
    wrong: list[Diagnostic] = []
    for name, at, value in fields:
        try:
            given[name] = _field(cls, name, value, what, at, read)
        except ValueRefused as refused:
            wrong += [refused.diagnostic, *refused.others]
    if wrong:
        raise ValueRefused(*wrong)
    missing = _missing(cls, given)
    if missing or not dataclasses.is_dataclass(cls):
        return _Partial(cls, given, missing, read)
    try:
        return cls(**_as_annotated(given, cls))
    except InvalidInput as error:
        refuse(mark, "value", f"{what}: {error}", "correct the fields, or give only those that are read")


def _field(cls: type, name: str, value: V, what: str, at: Mark, read: FieldReader[V]) -> Any:
    """Return the value of one field; `at` is the place of its name. Raises ValueRefused."""
    known, arrays = attributes(cls), array_fields(cls)
    if name in arrays:
        return read.array(value, arrays[name], f"{what}.{name}")
    if name not in known:
        refuse(at, "attribute-unknown", f"{cls.__name__} has no {name!r}", did_you_mean(name, {**known, **arrays}))
    return read.value(value, known[name], annotations_of(cls)[name], f"{what}.{name}")


def _missing(cls: type, given: Mapping[str, Any]) -> list[str]:
    """Return the fields that a record of its class needs beside those given."""
    fields = dataclasses.fields(cls) if dataclasses.is_dataclass(cls) else ()
    none = dataclasses.MISSING
    needed = (f.name for f in fields if f.init and f.default is none and f.default_factory is none)
    return [name for name in needed if name not in given]


def _as_annotated(given: Mapping[str, Any], cls: type) -> dict[str, Any]:
    """Return fields with lists as tuples where the class has tuples."""
    hints = typing.get_type_hints(cls)
    return {
        name: tuple(value) if isinstance(value, list) and typing.get_origin(hints[name]) is tuple else value
        for name, value in given.items()
    }


def _defaults(cls: type) -> dict[str, Any]:
    """Return the fields that a class gives by itself."""
    fields = dataclasses.fields(cls) if dataclasses.is_dataclass(cls) else ()
    return {f.name: f.default for f in fields if f.init and f.default is not dataclasses.MISSING}


class _FieldNotGiven(UnsetKey, AttributeError):
    """A field of a record is read that was not given."""


class _Partial:
    """A record of which some fields are given."""

    def __init__(self, cls: type, given: Mapping[str, Any], missing: list[str], read: FieldReader[Any]) -> None:
        self.__dict__.update(given)
        self._cls = cls
        self._missing = missing
        self._fields = {field.name for field in dataclasses.fields(cls)} if dataclasses.is_dataclass(cls) else set()
        if read.defaults:
            self.__dict__.update({name: value for name, value in _defaults(cls).items() if name not in given})
        self._called = read.origin.format(cls.__name__)
        self._remedy = read.remedy

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # a node may write it to a port of its class
        return self._cls

    def __repr__(self) -> str:
        fields = ((name, value) for name, value in vars(self).items() if not name.startswith("_"))
        return f"<{self._called} with {', '.join(f'{name}={brief(value)}' for name, value in fields) or 'no field'}>"

    def __getattr__(self, field_name: str) -> Any:
        remedy = self._remedy.format(field_name)
        if self._missing and hasattr(self._cls, field_name) and field_name not in self._fields:
            remedy = f"it is worked out from all fields: give {', '.join(self._missing)} too"
        raise _FieldNotGiven(f"the {self._called} has no {field_name!r}; {remedy}")
