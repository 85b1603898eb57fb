"""One node ticked to its end, on values that a test makes by hand."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.blame import Broken, own_code
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.hardware.own_modules import ModuleRefused, Modules
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.given import Given
from stretch_bt.runtime.mock_arrays import array_fields
from stretch_bt.runtime.mock_value import record_of
from stretch_bt.runtime.runner import Runner
from stretch_bt.source import Mark, Scalar, did_you_mean
from stretch_bt.testing.scripted import ScriptedDevice
from stretch_bt.threads import one_thread
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.build import BuiltTree
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.made import made
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.registry import NodeInfo, load_all, lookup
from stretch_bt.tree.types import Type, attributes
from stretch_bt.tree.values import Refused, literal
from stretch_bt.units import Estimate

__all__ = ["NodeResult", "node_info", "tick_node"]

PERIOD = 0.05  # s, as of a tree that does not say
#: ticks after which a node that goes on is ended; ten minutes of virtual time
MOST_TICKS = 12_000


@dataclass(frozen=True)
class NodeResult:
    """How a node ended, and what it wrote.

    Parameters
    ----------
    status
        SUCCESS or FAILURE, as of a run; also ERROR where its code broke, or FAULT where a device did.
    reason
        Why it did not succeed.
    outputs
        What it wrote, by port, SI; a number with a deviation is an Estimate, and None is an output that it left absent. Each is an
        attribute of the result too.
    ticks, seconds
        How many ticks it took, and s of virtual time.
    broken
        Where own code broke.
    """

    status: str
    reason: str
    outputs: dict[str, Any]
    ticks: int
    seconds: float
    broken: list[Broken] = field(default_factory=list)

    def __getattr__(self, name: str) -> Any:
        outputs = self.__dict__.get("outputs", {})
        if name not in outputs:
            wrote = f"it wrote {', '.join(outputs)}" if outputs else "it wrote nothing"
            ended = f"; it ended with {self.status}: {self.reason}" if self.__dict__.get("reason") else ""
            raise AttributeError(f"the node wrote no {name!r}; {wrote}{ended}")
        return outputs[name]


def node_info(name: str | type[Behavior], home: Path) -> NodeInfo:
    """Return a registered node by its name, by `module.name`, or by its class; the module may stand in the folder `home`.

    Raises
    ------
    InvalidInput
        There is none; the message has the nearest name.
    """
    if isinstance(name, type):
        found = next((info for info in load_all().values() if info.cls is name), None)
        if found is None:
            raise InvalidInput(f"{name.__name__} is no registered node; write @node above the class")
        return found
    module, _, last = name.rpartition(".")
    if module and module not in sys.modules and lookup(name) is None:
        try:
            Modules(home, home, "put the module beside the test, or install the package").bring(module, home / "test")
        except ModuleRefused as refused:
            raise InvalidInput(f"node {name!r}: {refused}; {refused.hint}") from None
    found = lookup(last)
    if found is None:
        raise InvalidInput(_no_node(last, module))
    return found


def _no_node(name: str, module: str) -> str:
    own = [
        known for known, info in load_all().items() if info.cls.__module__.partition(".")[0] == module.partition(".")[0]
    ]
    if module and own:
        return f"module {module!r} has no node {name!r}; {did_you_mean(name, own)}"
    hint = did_you_mean(name, load_all()) or "`stretch-bt nodes` lists them"
    return f"no node {name!r} is registered; {hint}, or import the module of your own node"


def tick_node(info: NodeInfo, inputs: Mapping[str, Any], folder: Path | None = None) -> NodeResult:
    """Tick a node on inputs, by port, until it ends; raises InvalidInput with every input that is wrong."""
    values, devices = _read_inputs(info, inputs)
    given = Given(devices)
    context = RunContext(given.hand)
    context.folder, context.devices, context.limits = folder, devices, given.limits
    node = _wired(info, values, context)
    tree = BuiltTree(node, None, {}, {info.name: node}, list(node.sinks.values()))
    with one_thread():
        with own_code(info.name, "prepare()"):
            node.prepare()
        runner = Runner(tree, context, given.clock, period=PERIOD, cell=given, max_ticks=MOST_TICKS)
        outcome = runner.run()
    reason = outcome.reason.removeprefix(f"{info.name}: ")
    return NodeResult(outcome.status, reason, dict(_written(node)), outcome.ticks, outcome.task_seconds, outcome.broken)


def _wired(info: NodeInfo, values: Mapping[str, Any], context: RunContext) -> Behavior:
    """Return the node with its ports bound to values, where none is given to their defaults."""
    node = made(info.cls, info.name)
    node.path, node.context = info.name, context
    node.device_names = {port.name: port.name for port in info.of(Role.DEVICE) if port.name in context.devices}
    for port in info.of(Role.INPUT):
        value = values.get(port.name, port.default)
        node.wiring[port.name] = partial(_same, value)
    for port in info.of(Role.INOUT):
        if values.get(port.name) is not None:
            node.sinks[port.name].write(values[port.name], "the test")
    return node


def _same(value: Any) -> Any:
    return value


def _written(node: Behavior) -> Iterator[tuple[str, Any]]:
    for name, cell in node.sinks.items():
        if cell.value is not MISSING:
            yield name, cell.held()
        elif cell.writer:
            yield name, None


# --- what a test gives


def _read_inputs(info: NodeInfo, inputs: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the values of ports and the devices among some inputs."""
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
    return f"no input {name!r}; {did_you_mean(name, takes) or 'it takes ' + ', '.join(takes)}"


def _absent(info: NodeInfo, inputs: Mapping[str, Any]) -> list[Port]:
    """Return the ports without which the node cannot be ticked and that are not given."""
    needed = (p for p in info.ports.values() if p.required or (p.role is Role.DEVICE and not p.optional))
    return [port for port in needed if port.name not in inputs]


def _missing(port: Port, type_: Type) -> str:
    if port.role is Role.DEVICE:
        return f'{port.name} is missing; give {port.name}=scripted_device("{type_.name}")'
    return f"{port.name} is missing; it takes {port.check({}).expected()}"


def _device(port: Port, type_: Type, given: Any) -> Any:
    kind = given.kind if isinstance(given, ScriptedDevice) else None
    fits = kind == type_.name if kind else isinstance(given, INTERFACES[type_.name])
    if not fits:
        hint = f'give {port.name}=scripted_device("{type_.name}")'
        raise InvalidInput(f"it takes a device, {type_.name}, not {kind or shown(given)}; {hint}")
    return given


def _value(port: Port, info: NodeInfo, given: Any) -> Any:
    try:
        return port.check(info.ports).judge(_plain(given, info.types[port.name], port.name))
    except Refused as refused:
        found = refused.diagnostic
        raise InvalidInput(found.message + (found.hint and f"; {found.hint}")) from None


def _plain(given: Any, type_: Type, name: str) -> Any:
    """Return what a value stands for: text by its unit, arrays as lists, a mapping as a record that has these fields alone."""
    if isinstance(given, np.ndarray) and not type_.is_record:
        given = given.tolist()
    if isinstance(given, list | tuple) and type_.item is not None:
        return [_plain(item, type_.item, f"{name}[{k}]") for k, item in enumerate(given)]
    if isinstance(given, str) and not type_.is_record and type_.item is None:
        return literal(Scalar(given, False, Mark(name, 1, 1)), type_, name)
    if isinstance(given, Mapping) and type_.is_record and type_.item is None:
        return _record(given, type_, name)
    return given


def _record(given: Mapping[str, Any], type_: Type, name: str) -> Any:
    """Return the record of a mapping from its fields to numbers, text, arrays or mappings."""
    assert type_.cls is not None
    known, arrays = attributes(type_.cls), array_fields(type_.cls)
    wrong = [field for field in given if field not in known and field not in arrays]
    if wrong:
        raise InvalidInput(f"a {type_} has no {wrong[0]!r}; {did_you_mean(wrong[0], {**known, **arrays})}")
    fields = {
        field: np.asarray(value, arrays[field]) if field in arrays else _plain(value, known[field], f"{name}.{field}")
        for field, value in given.items()
    }
    return record_of(type_.cls, fields)


def _with_deviations(info: NodeInfo, values: dict[str, Any]) -> dict[str, Any]:
    """Return the values; the deviation of an Estimate goes to the port beside it that takes one, as in a tree."""
    found = dict(values)
    for name, value in values.items():
        if isinstance(value, Estimate) and info.ports[name].role is Role.INPUT:
            found[name] = float(value)
            if f"{name}_sd" in info.ports:
                found.setdefault(f"{name}_sd", value.sd)
    return found
