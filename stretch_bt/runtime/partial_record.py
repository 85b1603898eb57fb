"""Records that a person writes by hand, all fields of them or some: in a mocks file, and as a mapping in a test."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from stretch_bt.brief import brief
from stretch_bt.errors import InvalidInput, UnsetKey
from stretch_bt.runtime.mock_arrays import array_fields
from stretch_bt.source import Mark, did_you_mean
from stretch_bt.tree.types import Type, annotations_of, attributes
from stretch_bt.tree.values import refuse

__all__ = ["FieldReader", "record_of"]

V = TypeVar("V")


@dataclass(frozen=True, slots=True)
class FieldReader(Generic[V]):
    """How fields are written by hand.

    Parameters
    ----------
    array
        Reads one that is an array, of a type where the class names it; given its name for messages. Raises Refused.
    value
        Reads any other one; given its type, the annotation that it has in its class, and its name for messages. Raises Refused.
    origin
        What messages call a record with some fields, as in `mocked {}`.
    remedy
        What to do where another field is read, as in `add it to the mock's outputs`; `{}` stands for its name.
    """

    array: Callable[[V, np.dtype[Any] | None, str], Any]
    value: Callable[[V, Type, Any, str], Any]
    origin: str
    remedy: str


def record_of(cls: type, fields: Iterable[tuple[str, Mark, V]], what: str, mark: Mark, read: FieldReader[V]) -> Any:
    """Return a record of fields by their names, each with the place of its name.

    It is one of its class where these are all fields, else one that says so where another field is read.

    Raises
    ------
    Refused
        A name is no field, a field does not fit its type, or the class refuses the fields.
    """
    known, annotations, arrays = attributes(cls), annotations_of(cls), array_fields(cls)
    given: dict[str, Any] = {}
    for name, at, value in fields:
        if name in arrays:
            given[name] = read.array(value, arrays[name], f"{what}.{name}")
        elif name in known:
            given[name] = read.value(value, known[name], annotations[name], f"{what}.{name}")
        else:
            hint = did_you_mean(name, {**known, **arrays})
            refuse(at, "attribute-unknown", f"{cls.__name__} has no {name!r}", hint)
    if not dataclasses.is_dataclass(cls) or {f.name for f in dataclasses.fields(cls) if f.init} != given.keys():
        return _Partial(cls, given, read.origin, read.remedy)
    try:
        return cls(**_as_annotated(given, cls))
    except InvalidInput as error:
        refuse(mark, "value", f"{what}: {error}", "correct the fields, or give only those that are read")


def _as_annotated(given: Mapping[str, Any], cls: type) -> dict[str, Any]:
    """Return fields with lists as tuples where the class has tuples."""
    hints = typing.get_type_hints(cls)
    return {
        name: tuple(value) if isinstance(value, list) and typing.get_origin(hints[name]) is tuple else value
        for name, value in given.items()
    }


class _FieldNotGiven(UnsetKey, AttributeError):
    """A field of a record is read that was not given."""


class _Partial:
    """A record of which some fields are given."""

    def __init__(self, cls: type, given: Mapping[str, Any], origin: str, remedy: str) -> None:
        self.__dict__.update(given)
        self._cls = cls
        self._called = origin.format(cls.__name__)
        self._remedy = remedy

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # a node may write it to a port of its class
        return self._cls

    def __repr__(self) -> str:
        fields = ((name, value) for name, value in vars(self).items() if not name.startswith("_"))
        return f"<{self._called} with {', '.join(f'{name}={brief(value)}' for name, value in fields) or 'no field'}>"

    def __getattr__(self, field_name: str) -> Any:
        raise _FieldNotGiven(f"the {self._called} has no {field_name!r}; {self._remedy.format(field_name)}")
