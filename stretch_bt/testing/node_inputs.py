"""What a test gives to one node: its values by port, and its devices."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.interfaces import INTERFACES, is_one, kind_of
from stretch_bt.runtime.mock_arrays import array_of
from stretch_bt.runtime.partial_record import FieldReader, record_of
from stretch_bt.source import Mark, Scalar, did_you_mean
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.port_check import PortCheck
from stretch_bt.tree.types import Type
from stretch_bt.tree.values import ValueRefused, literal
from stretch_bt.units import Estimate

__all__ = ["read_inputs"]


def read_inputs(info: NodeInfo, inputs: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the values of ports, SI, and the devices among some inputs.

    Raises
    ------
    InvalidInput
        Some are wrong or missing; the message names each of them.
    """
    values: dict[str, Any] = {}
    devices: dict[str, Any] = {}
    wrong = [_unknown(info, name) for name in inputs if not _takes(info, name)]
    for name, given in ((n, g) for n, g in inputs.items() if _takes(info, n)):
        port = info.ports[name]
        try:
            if port.role is Role.DEVICE:
                devices[name] = _device(port, info.types[name], given)
            else:
                values[name] = _value(port, info, given)
        except InvalidInput as error:
            wrong.append(str(error) if str(error).startswith(name) else f"{name}: {error}")
    wrong += [_missing(port, info.types[port.name]) for port in _absent(info, inputs)]
    if wrong:
        raise InvalidInput(f"tick_node({info.name!r}): " + "\n  ".join(wrong))
    return _with_deviations(info, values), devices


def _takes(info: NodeInfo, name: str) -> bool:
    return name in info.ports and info.ports[name].role is not Role.OUTPUT


def _unknown(info: NodeInfo, name: str) -> str:
    takes = [port for port in info.ports if _takes(info, port)]
    if name in info.outputs:
        return f"{name} is an output; the result has it"
    return f"no input {name!r}; {did_you_mean(name, takes) or 'it takes ' + (', '.join(takes) or 'none')}"


def _absent(info: NodeInfo, inputs: Mapping[str, Any]) -> list[Port]:
    """Return the ports without which the node cannot be ticked and that are not given."""
    needed = (p for p in info.ports.values() if p.required or (p.role is Role.DEVICE and not p.optional))
    return [port for port in needed if port.name not in inputs]


def _missing(port: Port, type_: Type) -> str:
    if port.role is Role.DEVICE:
        return f'{port.name} is missing; give {port.name}=scripted_device("{type_.name}")'
    return f"{port.name} is missing; it takes {port.check({}).expected()}"


def _device(port: Port, type_: Type, given: Any) -> Any:
    if not is_one(given, INTERFACES[type_.name]):
        hint = f'give {port.name}=scripted_device("{type_.name}")'
        raise InvalidInput(f"it takes a device, {type_.name}, not {kind_of(given)}; {hint}")
    return given


def _value(port: Port, info: NodeInfo, given: Any) -> Any:
    try:
        return port.check(info.ports).judge(_plain(given, info.types[port.name], port.name))
    except ValueRefused as refused:
        found = refused.diagnostic
        raise InvalidInput(found.message + (found.hint and f"; {found.hint}")) from None


def _plain(given: Any, type_: Type, name: str) -> Any:
    """Return what a value stands for: text by its unit, arrays as lists, a mapping as a record that has these fields alone."""
    if isinstance(given, np.ndarray) and not type_.is_record:
        given = given.tolist()
    if isinstance(given, Enum) and given.name in type_.options:
        return given.name
    if isinstance(given, list | tuple) and type_.item is not None:
        return [_plain(item, type_.item, f"{name}[{k}]") for k, item in enumerate(given)]
    if isinstance(given, str) and not type_.is_record and type_.item is None:
        return literal(Scalar(given, False, Mark(name, 1, 1)), type_, name)
    if isinstance(given, Mapping) and type_.is_record and type_.item is None:
        return _record(given, type_, name)
    return given


def _record(given: Mapping[str, Any], type_: Type, name: str) -> Any:
    """Return the record of a mapping from its fields to numbers, text, arrays, records or mappings; raises ValueRefused."""
    assert type_.cls is not None
    mark = Mark(name, 1, 1)

    def array(value: Any, dtype: np.dtype[Any] | None, field: str) -> Any:
        return None if value is None else array_of(value, dtype, field, mark)

    def plain(value: Any, type_: Type, annotation: Any, field: str) -> Any:
        try:
            return PortCheck(annotation, None, None).judge(_plain(value, type_, field))
        except InvalidInput as error:
            raise ValueRefused(mark.error("value", f"{field}: {error}")) from None

    remedy = f"give it too, as in {name}={{{{'{{}}': ...}}}}"
    reader = FieldReader(array, plain, "{} of the test", remedy, defaults=True)
    return record_of(type_.cls, ((str(field), mark, value) for field, value in given.items()), name, mark, reader)


def _with_deviations(info: NodeInfo, values: dict[str, Any]) -> dict[str, Any]:
    """Return the values; the deviation of an Estimate goes to the port beside it that takes one, as in a tree."""
    found = dict(values)
    for name, value in values.items():
        if isinstance(value, Estimate) and info.ports[name].role is Role.INPUT:
            found[name] = float(value)
            if f"{name}_sd" in info.ports:
                found.setdefault(f"{name}_sd", value.sd)
    return found
