"""A call of a tree by another: only `in` and `out` cross the border, local keys are fresh at each start."""

from __future__ import annotations

from collections.abc import Container, Generator, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Mark
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.document import Signature
from stretch_bt.tree.flow.base import Flow, FlowNode, Known, Part, Wire, why_failed

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.feeds import BorrowedCell, Relay

__all__ = ["Call", "CallNode"]


@dataclass(slots=True)
class Call(Part):
    """A tree used as a node."""

    target: Signature
    inputs: dict[str, Wire] = field(default_factory=dict)
    outputs: dict[str, tuple[str, Mark]] = field(default_factory=dict)
    inouts: dict[str, tuple[str, Mark]] = field(default_factory=dict)
    left_out: set[str] = field(default_factory=set)  # records that the file does not name
    devices: dict[str, str] = field(default_factory=dict)  # of the caller, by what the tree calls them
    long: bool = True
    keyword: ClassVar[str] = "call"

    @property
    def label(self) -> str:
        """The given name, or the tree's without its prefix."""
        return self.name or self.target.name

    def is_long(self) -> bool:
        """A called tree is taken to need more than one tick."""
        return self.long

    def written(self) -> dict[str, str]:
        """Return its ports."""
        inputs = {name: wire.text for name, wire in self.inputs.items()}
        return {
            **self.devices,
            **inputs,
            **{name: f"${key}" for name, (key, _) in (self.inouts | self.outputs).items()},
        }

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Inputs must be written; outputs are, on SUCCESS, because the called tree was checked for it."""
        data.read(self.inputs.values(), known)
        data.read_over(self.inouts, {name for name in self.inouts if self.target.inouts[name].has_default}, known)
        return Flow(known | {key for key, _ in (*self.outputs.values(), *self.inouts.values())}, known)

    def own_writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield the keys of its outputs, and of what it writes over."""
        yield from ((key, self.label, mark) for key, mark in (*self.outputs.values(), *self.inouts.values()))

    def absent(self, known: Container[str]) -> set[str]:
        """Return the keys of its outputs: the called tree may have written `none` to any of them."""
        return {key for key, _ in (*self.outputs.values(), *self.inouts.values())}

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the called tree with cells of its own."""
        return builder.call(self, path)


class CallNode(FlowNode):
    """Clears the local keys at each start, then ticks the body; `finish` runs after the body, whatever it ended with."""

    def __init__(
        self,
        path: str,
        child: py_trees.behaviour.Behaviour,
        local: list[tuple[Cell, Any]],
        finish: py_trees.behaviour.Behaviour | None = None,
        shared: list[tuple[Cell, Any]] | None = None,
        relays: Sequence[Relay] = (),
        borrowed: Sequence[BorrowedCell] = (),
    ) -> None:
        super().__init__(path, child)
        self.local = local
        self.shared = shared or []  # keys of the caller that have a default here
        self.relays = relays
        self.borrowed = borrowed
        self.finish = finish
        self.result: Status | None = None
        self.entered = False
        if finish is not None:
            self.children.append(finish)
            finish.parent = self

    def begin(self) -> None:
        """Forget what an earlier call left."""
        self.result = None
        self.entered = True
        for cell, default in self.local:
            cell.reset(default)
        for relay in self.relays:
            relay.begin()
        for cell, default in self.shared:
            if cell.value is MISSING and (default is not None or not cell.writer):
                cell.give(default, self.path)
        for lent in self.borrowed:
            lent.begin()

    def handed_on(self) -> list[tuple[Cell, Cell]]:
        """Return the cells of the called tree whose values go on to a key of the caller, with that key."""
        return [(relay.inner, relay.outer) for relay in self.relays] + [(lent, lent.outer) for lent in self.borrowed]

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Tick the body, then `finish`; an output that they did not write has its default once they succeeded."""
        status = yield from self._decided()
        if status is Status.SUCCESS:
            for relay in self.relays:
                relay.succeed(self.path)
        return status

    def _decided(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        if self.result is None:
            yield from self.child.tick()
            if self.child.status is Status.RUNNING or self.finish is None:
                if getattr(self.child, "explains", True):
                    self.feedback_message = self.child.feedback_message
                self.entered = self.child.status is Status.RUNNING
                return self.child.status
            self.result = self.child.status
        assert self.finish is not None
        yield from self.finish.tick()
        if self.finish.status is Status.RUNNING:
            return Status.RUNNING
        self.entered = False
        if self.finish.status is Status.FAILURE:
            before = f"{why_failed(self.child)}; its " if self.result is Status.FAILURE else ""
            self.feedback_message = f"{before}finally failed: {why_failed(self.finish)}"
            return Status.FAILURE
        return self.result
