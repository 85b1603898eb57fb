"""What a mock writes: literals, numbers with their deviation, and records of which a file gives all or some fields."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stretch_bt.brief import brief
from stretch_bt.errors import InvalidInput, UnsetKey
from stretch_bt.runtime.mock_arrays import MockArrays, array_fields
from stretch_bt.source import Map, Seq, Value, did_you_mean
from stretch_bt.tree.types import Family, Type, attributes
from stretch_bt.tree.values import is_none, literal, refuse
from stretch_bt.units import Estimate

__all__ = ["mock_value", "record_of"]


def mock_value(value: Value, type_: Type, what: str, arrays: MockArrays | None = None) -> Any:
    """Return what a mock writes: a literal, `{value, sd}` of a number, or the fields of a record.

    Without `arrays` those that it names are files beside that of the value.

    Raises
    ------
    Refused
        The value does not fit the type; the diagnostic says where and what to write.
    """
    if type_.is_number and isinstance(value, Map):
        return _estimate(value, type_, what)
    if type_.item is not None and type_.is_record and isinstance(value, Seq):
        return [mock_value(item, type_.item, f"{what}[{i}]", arrays) for i, item in enumerate(value.items)]
    if type_.family is not Family.OBJECT or type_.cls is None:
        return None if is_none(value) else literal(value, type_, what)
    if not isinstance(value, Map):
        known = ", ".join(sorted({**attributes(type_.cls), **array_fields(type_.cls)})[:4])
        hint = f"write a mapping of some of {known}"
        refuse(value.mark, "type-mismatch", f"{what} takes the fields of a {type_}", hint)
    return _record(value, type_.cls, what, arrays or MockArrays(Path(value.mark.file).parent))


def _estimate(value: Map, type_: Type, what: str) -> Estimate:
    fields = {k.text: literal(v, type_, f"{what}.{k.text}") for k, v in value}
    if set(fields) != {"value", "sd"}:
        hint = "write '{value: 1 mm, sd: 0.1 mm}'"
        refuse(value.mark, "type-mismatch", f"{what} takes a value and its sd", hint)
    if fields["sd"] < 0:
        message = f"{what}.sd is a standard deviation, which is not below 0"
        refuse(value.mark, "out-of-bounds", message, "write '0' with its unit, or more")
    return Estimate(fields["value"], fields["sd"])


def _record(value: Map, cls: type, what: str, arrays: MockArrays) -> Any:
    """Return a record: of its class where all fields are given, else one that says so where another field is read."""
    known, of_arrays = attributes(cls), array_fields(cls)
    given: dict[str, Any] = {}
    for key, inner in value:
        name = f"{what}.{key.text}"
        if key.text not in known and key.text not in of_arrays:
            message = f"{cls.__name__} has no {key.text!r}"
            refuse(key.mark, "attribute-unknown", message, did_you_mean(key.text, {**known, **of_arrays}))
        if is_none(inner):
            given[key.text] = None
        elif key.text in of_arrays:
            given[key.text] = arrays.read(inner, of_arrays[key.text], name)
        else:
            given[key.text] = mock_value(inner, known[key.text], name, arrays)
    try:
        return record_of(cls, given)
    except InvalidInput as error:
        refuse(value.mark, "value", f"{what}: {error}", "correct the fields, or give only those that are read")


def record_of(cls: type, given: Mapping[str, Any]) -> Any:
    """Return a record of some fields: one of its class where these are all, else one that says so where another is read.

    Raises
    ------
    InvalidInput
        The class refuses the fields.
    """
    if not dataclasses.is_dataclass(cls) or {f.name for f in dataclasses.fields(cls) if f.init} != given.keys():
        return _Partial(cls, given)
    return cls(**_as_annotated(given, cls))


def _as_annotated(given: Mapping[str, Any], cls: type) -> dict[str, Any]:
    """Return fields with lists as tuples where the class has tuples."""
    hints = typing.get_type_hints(cls)
    return {
        name: tuple(value) if isinstance(value, list) and typing.get_origin(hints[name]) is tuple else value
        for name, value in given.items()
    }


class _FieldNotGiven(UnsetKey, AttributeError):
    """A field of a mocked object is read that the mocks file does not give."""


class _Partial:
    """An object of which a mocks file gives some fields."""

    def __init__(self, cls: type, given: Mapping[str, Any]) -> None:
        self.__dict__.update(given)
        self._name = cls.__name__
        self._cls = cls

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # a node may write it to a port of its class
        return self._cls

    def __repr__(self) -> str:
        fields = ((name, value) for name, value in vars(self).items() if not name.startswith("_"))
        return (
            f"<mocked {self._name} with {', '.join(f'{name}={brief(value)}' for name, value in fields) or 'no field'}>"
        )

    def __getattr__(self, field_name: str) -> Any:
        raise _FieldNotGiven(f"the mocked {self._name} gives no {field_name!r}; add it to the mock's outputs")
