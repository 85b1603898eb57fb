"""From a checked task to py_trees nodes: fresh nodes at every place, ports bound to cells, paths that stay the same."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any, Protocol, TypeVar

import py_trees

from stretch_bt.errors import TreeError
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.built_tree import BuiltTree, Node
from stretch_bt.tree.cell import MISSING, BoundedCell, Cell
from stretch_bt.tree.context import Context
from stretch_bt.tree.document import Declared
from stretch_bt.tree.explained import Explained
from stretch_bt.tree.feeds import (
    BorrowedCell,
    Computed,
    Relay,
    bounded,
    bounds_check,
    carried,
    constant,
    present,
    tee,
)
from stretch_bt.tree.flow import Call, Leaf, Part, Wire
from stretch_bt.tree.flow.call import CallNode
from stretch_bt.tree.flow.guard import Condition, Guard
from stretch_bt.tree.foreign.node import ForeignNode
from stretch_bt.tree.made import made_at
from stretch_bt.tree.paths import Paths
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.program import Program
from stretch_bt.tree.types import Type
from stretch_bt.tree.wire_reader import TreeCells, WireReader

__all__ = ["Builder", "Substitutes", "build"]

C = TypeVar("C", bound=py_trees.composites.Composite)


class Substitutes(Protocol):
    """What may stand in for nodes of an unedited tree, by path."""

    def node(self, path: str, part: Part, builder: Builder) -> Node | None:
        """Return a stand-in for the node at this path, or None."""
        ...

    def condition(self, path: str, builder: Builder) -> Callable[[], bool] | None:
        """Return a stand-in for the condition at this path, or None."""
        ...


def build(program: Program, context: Context, substitutes: Substitutes | None = None, within: str = "") -> BuiltTree:
    """Build the main tree of a checked program; touches no device. Paths begin with `within`, where several trees share devices.

    Raises
    ------
    TreeError
        The class of a node makes no node that could run.
    """
    return Builder(program, context, substitutes, within).main()


class Builder(WireReader):
    """Builds one tree; parts call it back for their children, cells and inputs."""

    def __init__(self, program: Program, context: Context, substitutes: Substitutes | None, within: str = "") -> None:
        self.program = program
        self.base = f"{within}/{program.entry}" if within else program.entry
        super().__init__(context, TreeCells(program.main.signature, self.base))
        self.substitutes = substitutes
        self.paths = Paths()
        self.nodes: dict[str, Node] = {}
        self.cells: list[Cell] = []
        self.devices: set[str] = set()
        #: classes that make no node, each with the error of its first place
        self.unmade: dict[type[Behavior], TreeError] = {}

    def main(self) -> BuiltTree:
        """Build the main tree; raises TreeError with every class of a node that makes none."""
        body = self.program.main
        border = (
            body.signature.outs,
            body.signature.ins,
            body.signature.inouts,
        )  # the latter two where it is no `main`
        self.own_cells(self.frame, [*body.signature.keys.values(), *(d for table in border for d in table.values())])
        root = self.root(body.part, self.base)
        finish = self.root(body.finish, f"{self.base}/finally") if body.finish else None
        if self.unmade:
            errors = list(self.unmade.values())
            raise TreeError([found for error in errors for found in error.diagnostics]) from errors[0].__cause__
        outputs = {name: (d, self.frame.cells[name]) for name, d in body.signature.outs.items()}
        return BuiltTree(root, finish, outputs, self.nodes, self.cells, self.devices, self.readings)

    # --- places

    def root(self, part: Part, base: str) -> Node:
        """Build the body of a tree, whose nodes are called by `base`."""
        return self.place(part, self.paths.root(part, base))

    def child(self, owner: Part, part: Part, path: str) -> Node:
        """Build a child of the part at `path`."""
        return self.place(part, self.paths.child(owner, part, path))

    def place(self, part: Part, path: str) -> Node:
        """Build one part, or its stand-in, and register it by its path."""
        node: Node = None
        if self.substitutes is not None and not isinstance(part, Guard):
            node = self.substitutes.node(path, part, self)
        if node is None:
            node = part.build(self, path)
        node.name = path.rpartition("/")[2]
        node.path = path
        self.nodes[path] = node
        return node

    def group(self, node: C, part: Part, path: str) -> C:
        """Add the children of a part to a py_trees composite."""
        for child in part.children():
            node.add_child(self.child(part, child, path))
        return node

    def outputs(self, part: Part) -> dict[str, tuple[Cell, Type]]:
        """Return the cells that a part writes, by port, or by key where it has none; an output that the tree does not take goes nowhere."""
        if isinstance(part, Leaf):
            types, keys = part.info.outputs | part.info.inouts, part.outputs | part.inouts
        elif isinstance(part, Call):
            given = part.target.outs | part.target.deviations | part.target.inouts
            types = {name: d.type for name, d in given.items()}
            keys = part.outputs | part.inouts
        else:
            names = {key: self.frame.scope.signature.declared(key) for key, _, _ in part.writes()}
            return {key: (self.cell(key), declared.type) for key, declared in names.items() if declared is not None}
        return {
            port: (self.cell(keys[port][0]) if port in keys else Cell(port), type_) for port, type_ in types.items()
        }

    # --- cells

    def own_cells(self, frame: TreeCells, declared: list[Declared]) -> list[tuple[Cell, Any]]:
        """Add fresh cells to a frame and return them with their defaults."""
        fresh = []
        for d in declared:
            default = d.default if d.has_default else MISSING
            cell = _cell_of(d, f"{frame.path}/{d.name}")
            cell.reset(default)
            frame.cells[d.name] = cell
            fresh.append((cell, default))
            self.cells.append(cell)
        return fresh

    def condition(self, wire: Wire, path: str) -> Condition:
        """Return a condition with what explains it."""
        substitute = self.substitutes.condition(path, self) if self.substitutes else None
        if substitute is not None:
            return Condition(wire.text, substitute, lambda: "mocked")
        if wire.expression is None:
            return Condition(wire.text, self.thunk(wire), lambda: "")
        seen = Explained(wire.expression, self, self.frame.scope)
        return Condition(wire.text, seen.holds, seen.shown)

    # --- nodes and calls

    def leaf(self, part: Leaf, path: str) -> Behavior:
        """Build a node of the registry with its ports bound."""
        try:
            node = made_at(part.info.cls, path, part.mark)
        except TreeError as error:
            self.unmade.setdefault(part.info.cls, error)
            node = Behavior(path)
        node.path = path
        node.context = self.context
        node.device_names = {port: self.frame.devices.get(name, name) for port, name in part.devices.items()}
        self.devices.update(node.device_names.values())
        for declared in part.info.of(Role.INPUT):
            node.wiring[declared.name] = self.port(part, declared)
        if isinstance(node, ForeignNode):
            node.given = part.arguments()
        for name, (key, _) in part.inouts.items():
            node.sinks[name] = self.cell(key)
        for declared in part.info.of(Role.OUTPUT):
            cell = self.cell(part.outputs[declared.name][0]) if declared.name in part.outputs else Cell(declared.name)
            if isinstance(cell, BoundedCell):  # which a number would pass by
                cell = Relay(Cell(cell.name), cell).inner
            sd = part.outputs.get(f"{declared.name}_sd")
            if sd is not None and f"{declared.name}_sd" not in part.info.ports:
                cell = tee(cell, self.cell(sd[0]))
            node.sinks[declared.name] = cell
        return node

    def port(self, part: Leaf, declared: Port) -> Callable[[], Any]:
        """Return a function that reads an input port; a list is the node's own, so that it changes no key, param or default."""
        read = self._fed(part, declared)
        return read if part.info.types[declared.name].item is None else lambda: copy(read())

    def _fed(self, part: Leaf, declared: Port) -> Callable[[], Any]:
        """Return a function that gives an input its wired value, else the error of its quantity's wired value, else its default."""
        default, wire = declared.default, part.inputs.get(declared.name)
        quantity = part.inputs.get(declared.name.removesuffix("_sd")) if declared.name.endswith("_sd") else None
        if wire is None and quantity is not None and (error := self.error_of(quantity)) is not None:
            return carried(error, default, declared.name)
        if wire is None:
            return lambda: default
        thunk = self.thunk(wire)
        if not wire.is_constant and (wire.optional or wire.may_be_absent or declared.check({}).optional):
            thunk = present(thunk, default)
        if wire.is_constant or (declared.min, declared.max) == (None, None):
            return thunk
        return bounded(thunk, bounds_check(declared.name, part.info.types[declared.name], declared.min, declared.max))

    def call(self, part: Call, path: str) -> CallNode:
        """Build a called tree with cells of its own."""
        body = self.program.body(part.target)
        given = {name: self.frame.devices.get(outer, outer) for name, outer in part.devices.items()}
        frame = TreeCells(part.target, path, devices=self.frame.devices | given)
        for declared in part.target.ins.values():
            frame.cells[declared.name] = self.input_cell(declared, part.inputs.get(declared.name), path)
        taken = {d.name: self.taken(part, d, path) for d in part.target.outs.values()}
        private = [d for d in part.target.outs.values() if taken[d.name] is None]
        private += [d for d in part.target.inouts.values() if d.name not in part.inouts]
        shared = [(self.cell(key), part.target.inouts[name]) for name, (key, _) in part.inouts.items()]
        borrowed = []
        for outer_cell, declared in shared:
            frame.cells[declared.name] = outer_cell
            if declared.bounded:
                frame.cells[declared.name] = lent = _borrowed(declared, outer_cell, path)
                borrowed.append(lent)
        defaults = [(cell, d.default) for cell, d in shared if d.has_default and not d.may_be_absent]
        relays = []
        for declared in part.target.outs.values():
            if (wired := taken[declared.name]) is None:
                continue
            inner = frame.cells[declared.name] = _cell_of(declared, f"{path}/{declared.name}")
            relays.append(Relay(inner, wired, declared.default if declared.has_default else MISSING))
        local = self.own_cells(frame, [*part.target.keys.values(), *private])
        outer, self.frame = self.frame, frame
        try:
            child = self.root(body.part, path)
            finish = self.root(body.finish, f"{path}/finally") if body.finish else None
        finally:
            self.frame = outer
        for relay in relays:
            relay.outer.blocked = relay.outer.blocked or relay.inner.blocked
        return CallNode(path, child, local, finish, defaults, relays, borrowed)

    def taken(self, part: Call, declared: Declared, path: str) -> Cell | None:
        """Return the cell of an output that the caller takes, or takes the deviation of; None of any other."""
        value, sd = part.outputs.get(declared.name), part.outputs.get(f"{declared.name}_sd")
        if f"{declared.name}_sd" in part.target.outs:
            sd = None  # an output of its own
        cell = None if value is None else self.cell(value[0])
        return cell if sd is None else tee(cell or Cell(f"{path}/{declared.name}"), self.cell(sd[0]))

    def input_cell(self, declared: Declared, wire: Wire | None, path: str) -> Cell:
        """Return the cell of an input: the caller's own, a constant, or one that is worked out at each read."""
        if wire is None:
            return constant(f"{path}/{declared.name}", declared.default, path)
        error = self.error_of(wire)
        if wire.is_constant:
            cell = constant(f"{path}/{declared.name}", wire.value, path)
            cell.sd = None if error is None else error()
            return cell
        key, thunk = wire.single_key(), self.thunk(wire)
        if declared.bounded:
            thunk = bounded(thunk, bounds_check(declared.name, declared.type, *declared.own_bounds))
        elif key is not None:
            return self.cell(key)
        return Computed(f"{path}/{declared.name}", thunk, error)


def _borrowed(declared: Declared, outer: Cell, path: str) -> BorrowedCell:
    """Return the cell of a caller's key under the bounds of an `inout` of the called tree."""
    check = bounds_check(f"${declared.name}", declared.type, *declared.own_bounds)
    return BorrowedCell(f"{path}/{declared.name}", outer, check)


def _cell_of(declared: Declared, name: str) -> Cell:
    """Return the cell of a declared name, which takes no value outside the bounds that the file gives it."""
    if not declared.bounded:
        return Cell(name)
    return BoundedCell(name, bounds_check(f"${declared.name}", declared.type, *declared.own_bounds))
