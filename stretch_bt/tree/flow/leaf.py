"""A call of a registered node, with its ports wired."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import py_trees

from stretch_bt.source import Mark
from stretch_bt.tree.flow.base import Flow, Known, Part, Wire
from stretch_bt.tree.node_info import NodeInfo

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow

__all__ = ["Leaf"]


@dataclass(slots=True)
class Leaf(Part):
    """A node of the registry."""

    info: NodeInfo
    inputs: dict[str, Wire] = field(default_factory=dict)
    outputs: dict[str, tuple[str, Mark]] = field(default_factory=dict)
    inouts: dict[str, tuple[str, Mark]] = field(default_factory=dict)
    left_out: set[str] = field(default_factory=set)  # records that the file does not name
    devices: dict[str, str] = field(default_factory=dict)
    keyword: ClassVar[str] = "node"

    @property
    def label(self) -> str:
        """The given name, or the node's."""
        return self.name or self.info.name

    def is_long(self) -> bool:
        """Whether the node may take more than one tick."""
        return not self.info.instant

    def wires(self) -> Sequence[Wire]:
        """Return what feeds the inputs."""
        return list(self.inputs.values())

    def arguments(self) -> dict[str, Any]:
        """Return the constructor arguments that it gives a behaviour; its class has its own defaults for the others."""
        return {name: wire.value for name, wire in self.inputs.items() if self.info.ports[name].fixed}

    def written(self) -> dict[str, str]:
        """Return its ports; a device only where it is not called like its port."""
        devices = {port: name for port, name in self.devices.items() if port != name}
        inputs = {name: wire.text for name, wire in self.inputs.items()}
        return {**devices, **inputs, **{name: f"${key}" for name, (key, _) in (self.inouts | self.outputs).items()}}

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Inputs must be written; outputs are, on SUCCESS."""
        data.read(self.inputs.values(), known)
        data.read_over(self.inouts, {name for name in self.inouts if not self.info.ports[name].required}, known)
        return Flow(known | {key for key, _ in (*self.outputs.values(), *self.inouts.values())}, known)

    def own_writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield the keys of its outputs, and of what it writes over."""
        yield from ((key, self.label, mark) for key, mark in (*self.outputs.values(), *self.inouts.values()))

    def absent(self, known: Container[str]) -> set[str]:
        """Return the keys of outputs that may be none."""
        optional = (name for name, check in self.info.written().items() if check.optional and name in self.outputs)
        return {self.outputs[name][0] for name in optional}

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the node with its ports bound to slots."""
        return builder.leaf(self, path)
