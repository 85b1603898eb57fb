"""What a mock writes: literals, numbers with their deviation, and records of which a file gives all or some fields."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.runtime.mock_arrays import MockArrays, array_fields, names_array
from stretch_bt.runtime.partial_record import FieldReader, record_of
from stretch_bt.source import Map, Scalar, Seq, Value, told
from stretch_bt.tree.port_check import PortCheck, allows_none
from stretch_bt.tree.types import FLOAT, Family, Type, attributes
from stretch_bt.tree.values import ValueRefused, check_bounds, example, is_none, literal, refuse, sample, written
from stretch_bt.units import Estimate

__all__ = ["check_entries", "check_port", "mock_value"]

#: characters of a value that a hint repeats
_SHOWN = 60


def mock_value(value: Value, type_: Type, what: str, arrays: MockArrays | None = None) -> Any:
    """Return what a mock writes: a literal, `{value, sd}` of a number, or the fields of a record.

    Without `arrays` the arrays that it names are files beside the file of the value.

    Raises
    ------
    ValueRefused
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


def check_port(given: Any, port: PortCheck, value: Value, what: str) -> None:
    """Raise ValueRefused where the node itself could not write what its mock writes; `value` is its place in the file."""
    if given is None and not port.optional:
        refuse(value.mark, "type-mismatch", f"{what} is never none", example(port.type))
    if given is not None:
        check_bounds(given, port.type, *port.bounds, value.mark, what)
    try:
        port.judge(given)
    except InvalidInput as error:
        refuse(value.mark, "type-mismatch", f"{what}: {error}", example(port.type))


def check_entries(values: list[Value], type_: Type, what: str) -> None:
    """Raise ValueRefused where an output that is a list is not given one list for each start, with the brackets to write.

    Parameters
    ----------
    values
        What a file gives, one for each start.
    type_
        Type of the output; all but a list passes.
    what
        Name of the output, for messages.
    """
    item = type_.item
    wrong = [v for v in values if not (isinstance(v, Seq) or is_none(v) or _names_numbers(v, type_))]
    if item is None or not wrong:
        return
    several = len(wrong) < len(values)
    meant = written(Seq(tuple(wrong[:1] if several else wrong), wrong[0].mark))
    if len(meant) > _SHOWN or not all(_fits(value, item) for value in wrong):
        meant = f"[{'{}' if type_.is_record else sample(item)}]"
    what = f"{what} takes {type_} for each start, and {told(wrong[0])} is no list"
    hint = f"write '{meant if several else f'[{meant}]'}'; the outer list has one list for each start"
    refuse(wrong[0].mark, "type-mismatch", what, hint)


def _names_numbers(value: Value, type_: Type) -> bool:
    return type_.item is not None and type_.item.is_number and names_array(value)


def _fits(value: Value, type_: Type) -> bool:
    try:
        mock_value(value, type_, "")
    except ValueRefused:
        return False
    return True


def _estimate(value: Map, type_: Type, what: str) -> Estimate:
    given = {k.text: v for k, v in value}
    unit = given.pop("unit", None)
    if unit is not None and not (isinstance(unit, Scalar) and unit.text == "SI"):
        refuse(unit.mark, "unit-unknown", f"{what}.unit is SI, where it is written", "write units beside the numbers")
    fields = {name: literal(v, type_ if unit is None else FLOAT, f"{what}.{name}") for name, v in given.items()}
    if set(fields) != {"value", "sd"}:
        hint = "write '{value: 1 mm, sd: 0.1 mm}'"
        refuse(value.mark, "type-mismatch", f"{what} takes a value and its sd", hint)
    _check_deviation(fields["sd"], value, f"{what}.sd")
    return Estimate(fields["value"], fields["sd"])


def _check_deviation(given: float, value: Value, what: str) -> None:
    if given < 0:
        message = f"{what} is a standard deviation, which is not below 0"
        refuse(value.mark, "out-of-bounds", message, "write '0' with its unit, or more")


def _record(value: Map, cls: type, what: str, arrays: MockArrays) -> Any:
    """Return a record: of its class where all fields are given, else one that says so where another field is read."""

    def array(inner: Value, dtype: np.dtype[Any] | None, name: str) -> Any:
        return None if is_none(inner) else arrays.read(inner, dtype, name)

    def plain(inner: Value, type_: Type, annotation: Any, name: str) -> Any:
        if is_none(inner) and not allows_none(annotation):
            refuse(inner.mark, "type-mismatch", f"{name} is never none", f"{example(type_)}, or leave it out")
        given = None if is_none(inner) else mock_value(inner, type_, name, arrays)
        if given is not None and name.endswith("_sd") and type_.is_number:
            _check_deviation(given, inner, name)
        return given

    fields = ((key.text, key.mark, inner) for key, inner in value)
    reader = FieldReader(array, plain, "mocked {}", "add it to the mock's outputs")
    return record_of(cls, fields, what, value.mark, reader)
