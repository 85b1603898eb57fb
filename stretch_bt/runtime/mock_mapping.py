"""Mocks that Python gives as a mapping, written as a mocks file has them: text, and the arrays that it names."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml
from py_trees.common import Status

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.runtime.mock_arrays import ARRAYS, array_fields
from stretch_bt.tree.types import Family, Type, attributes
from stretch_bt.units import Estimate

__all__ = ["WrittenMocks", "record_fields"]

Array = npt.NDArray[Any]
#: value of a field that no file can hold
_NOT_WRITTEN = object()


class WrittenMocks:
    """The text of a mapping of mocks, and by the text that names them its arrays.

    Raises
    ------
    InvalidInput
        Something in it cannot be written.
    """

    def __init__(self, mapping: Mapping[str, Any]) -> None:
        self.arrays: dict[str, Array] = {}
        self.text = yaml.safe_dump(self._plain(mapping, ""), sort_keys=False, allow_unicode=True)

    def _plain(self, value: Any, at: str, outputs: int = 0) -> Any:
        """Return a value as YAML writes it; `outputs` is how many mappings deep it stands in the outputs of a mock."""
        if isinstance(value, Mapping):
            return {str(key): self._plain(inner, *_below(at, str(key), outputs)) for key, inner in value.items()}
        if isinstance(value, list | tuple):
            return [self._plain(inner, f"{at}[{k}]", outputs) for k, inner in enumerate(value)]
        if isinstance(value, Status):
            return value.name.lower()
        if isinstance(value, Estimate):
            return {"value": float(value), "sd": value.sd, "unit": "SI"}
        if isinstance(value, np.ndarray) and value.ndim and (outputs > 1 or at.startswith("readings.")):
            return self._named(value, at)
        if isinstance(value, np.ndarray | np.generic):
            return value.tolist()
        if isinstance(value, str | bool | int | float):
            return value
        if dataclasses.is_dataclass(value) and not isinstance(value, type) and outputs:
            return self._record(value, at)
        raise InvalidInput(
            f"mocks: {at} is {shown(value)}; write text with a unit, a number, a list, a mapping or a record"
        )

    def _named(self, array: Array, at: str) -> str:
        name = f"{ARRAYS}#{at}"
        self.arrays[name] = array
        return name

    def _record(self, value: Any, at: str) -> dict[str, Any]:
        fields = record_fields(value)
        return {name: self._field(inner, f"{at}.{name}") for name, inner in fields.items()}

    def _field(self, value: Any, at: str) -> Any:
        if isinstance(value, np.ndarray):
            return self._named(value, at)
        if isinstance(value, list):
            return [self._field(inner, f"{at}[{k}]") for k, inner in enumerate(value)]
        return {k: self._field(v, f"{at}.{k}") for k, v in value.items()} if isinstance(value, dict) else value


def record_fields(record: Any) -> dict[str, Any]:
    """Return the fields of a record as a mocks file gives them: text with units, lists, mappings, and arrays as they are.

    Fields that no file can hold are left out; reading one of them in a run is an error that says so.
    """
    cls: type = type(record)
    types, arrays = attributes(cls), array_fields(cls)
    found: dict[str, Any] = {}
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        if field.name in arrays:
            found[field.name] = "none" if value is None else np.asarray(value)
        elif field.name in types:
            found[field.name] = _written(value, types[field.name])
    return {name: value for name, value in found.items() if value is not _NOT_WRITTEN}


def _written(value: Any, type_: Type) -> Any:
    if value is None:
        return "none"
    if type_.item is not None and isinstance(value, list | tuple):
        items = [_written(item, type_.item) for item in value]
        return _NOT_WRITTEN if any(item is _NOT_WRITTEN for item in items) else items
    if type_.family is Family.OBJECT:
        return record_fields(value) if dataclasses.is_dataclass(value) else _NOT_WRITTEN
    if isinstance(value, float) and not math.isfinite(value):
        return _NOT_WRITTEN
    if type_.kind is not None:
        return f"{float(value)!r} {type_.kind.si_unit}"
    return value.item() if isinstance(value, np.generic) else value


def _below(at: str, key: str, outputs: int) -> tuple[str, int]:
    """Return the place of an entry of a mapping, and how many mappings deep it stands in the outputs of a mock."""
    begins = key == "outputs" and at.startswith("mocks[")
    return (f"{at}.{key}" if at else key), outputs + (begins or outputs > 0)
