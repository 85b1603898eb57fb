"""One node ticked to its end, on values that a test makes by hand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from stretch_bt.blame import Broken
from stretch_bt.runtime.borrowed_devices import borrow
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.foreign_nodes import kept_for, paced_for
from stretch_bt.runtime.prepare_nodes import prepare_nodes
from stretch_bt.runtime.runner import Runner
from stretch_bt.testing.node_inputs import read_inputs
from stretch_bt.threads import one_thread
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.document import TICK
from stretch_bt.tree.foreign.node import ForeignNode
from stretch_bt.tree.made import made
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.port import Role
from stretch_bt.units import Estimate

__all__ = ["NodeResult", "tick_node"]

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
        attribute of the result too, and so is the deviation of `x` as `x_sd`.
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
        of = name.removesuffix("_sd")
        if name not in outputs and of != name and isinstance(outputs.get(of), Estimate):
            return outputs[of].sd
        if name not in outputs:
            wrote = f"it wrote {', '.join(outputs)}" if outputs else "it wrote nothing"
            ended = f"; it ended with {self.status}: {self.reason}" if self.__dict__.get("reason") else ""
            raise AttributeError(f"the node wrote no {name!r}; {wrote}{ended}")
        return outputs[name]


def tick_node(info: NodeInfo, inputs: Mapping[str, Any], folder: Path | None = None) -> NodeResult:
    """Tick a node on inputs, by port, until it ends; raises InvalidInput with every input that is wrong."""
    values, devices = read_inputs(info, inputs)
    given = borrow(devices)
    context = RunContext(given.hand)
    context.folder, context.devices, context.limits = folder, devices, given.limits
    node = _wired(info, values, context)
    tree = BuiltTree(node, None, {}, {info.name: node}, list(node.sinks.values()))
    with one_thread(), kept_for(tree):
        prepare_nodes(tree)
        clock = paced_for(tree, given.clock)
        runner = Runner(tree, context, clock, period=TICK, cell=given, max_ticks=MOST_TICKS)
        outcome = runner.run()
    reason = outcome.reason.removeprefix(f"{info.name}: ")
    written = dict(_written(node, ended_well=outcome.status == "SUCCESS"))
    return NodeResult(outcome.status, reason, written, outcome.ticks, outcome.task_seconds, outcome.broken)


def _wired(info: NodeInfo, values: Mapping[str, Any], context: RunContext) -> Behavior:
    """Return the node with its ports bound to values, where none is given to their defaults."""
    node = made(info.cls, info.name)
    node.path, node.context = info.name, context
    node.device_names = {port.name: port.name for port in info.of(Role.DEVICE) if port.name in context.devices}
    for port in info.of(Role.INPUT):
        value = values.get(port.name, port.default)
        node.wiring[port.name] = partial(_same, value)
    if isinstance(node, ForeignNode):
        node.given = {name: value for name, value in values.items() if info.ports[name].fixed}
    for port in info.of(Role.INOUT):
        if values.get(port.name) is not None:
            node.sinks[port.name].write(values[port.name], "the test")
    return node


def _same(value: Any) -> Any:
    return value


def _written(node: Behavior, *, ended_well: bool) -> Iterator[tuple[str, Any]]:
    """Yield what the node wrote by port; an optional output that it left out is None where it ended well."""
    for name, cell in node.sinks.items():
        if cell.value is not MISSING:
            yield name, cell.held()
        elif cell.writer or (ended_well and node.ports[name].check(node.ports).optional):
            yield name, None
