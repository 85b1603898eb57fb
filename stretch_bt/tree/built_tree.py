"""A tree that was built, with its nodes, cells and devices."""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.tree.cell import Cell
from stretch_bt.tree.document import Declared
from stretch_bt.tree.flow.call import CallNode
from stretch_bt.tree.foreign.node import ForeignNode

__all__ = ["BuiltTree", "Node"]

#: a py_trees behaviour that knows its `path`
Node = Any


@dataclass(slots=True)
class BuiltTree:
    """A tree ready to be ticked."""

    root: Node
    finish: Node | None
    outputs: dict[str, tuple[Declared, Cell]]
    nodes: dict[str, Node] = field(default_factory=dict)
    cells: list[Cell] = field(default_factory=list)
    devices: set[str] = field(default_factory=set)
    #: readings in expressions, as `arm.force`
    readings: set[str] = field(default_factory=set)
    #: whether a runner has it: nodes keep what they did, so a tree is run once
    taken: bool = False

    @property
    def foreign(self) -> list[ForeignNode]:
        """The nodes that tick behaviours of other packages, which go by the clock of the machine."""
        return [node for node in self.nodes.values() if isinstance(node, ForeignNode)]

    def needed(self, mocked: Container[str] = ()) -> set[str]:
        """Return the devices of nodes, and of the readings that are not mocked."""
        return self.devices | {reading.partition(".")[0] for reading in self.readings if reading not in mocked}

    def take_pending(self, under: Node | None = None) -> list[Node]:
        """Return each `finally` that is owed, the innermost first: of called trees that were entered, below a node or anywhere.

        It is owed once: whoever takes it runs it.
        """
        inside = None if under is None else {id(node) for node in under.iterate()}
        calls = [n for n in self.nodes.values() if isinstance(n, CallNode) and n.entered and n.finish is not None]
        calls = [n for n in calls if inside is None or id(n) in inside]
        for call in calls:
            call.entered = False
        return [call.finish for call in calls]

    def outline(self) -> list[tuple[int, str, str]]:
        """Return (depth, path, label) of every node, from the root down."""
        paths = {id(node): path for path, node in self.nodes.items()}

        def visit(node: Node, depth: int) -> Iterator[tuple[int, str, str]]:
            yield depth, paths.get(id(node), node.name), node.name
            for child in node.children:
                yield from visit(child, depth + 1)

        rows = list(visit(self.root, 0))
        return rows + (list(visit(self.finish, 0)) if self.finish else [])
