"""From a checked task to py_trees nodes: fresh nodes at every place, ports bound to cells, paths that stay the same."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

import py_trees

from stretch_bt.errors import NoAnswer, NodeError
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.blame import own_code
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.context import Context
from stretch_bt.tree.document import Declared, Signature
from stretch_bt.tree.explained import Explained
from stretch_bt.tree.expression import bind
from stretch_bt.tree.expression.parse import Name
from stretch_bt.tree.expression.typecheck import Origin
from stretch_bt.tree.flow import Call, Leaf, Part, Wire
from stretch_bt.tree.flow.call import CallNode
from stretch_bt.tree.flow.guard import Condition, Guard
from stretch_bt.tree.made import made
from stretch_bt.tree.paths import Paths
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.program import Program
from stretch_bt.tree.scope import TreeScope
from stretch_bt.tree.types import Type
from stretch_bt.tree.values import outside, within
from stretch_bt.units import Estimate

__all__ = ["Builder", "BuiltTree", "Substitutes", "build"]

#: a py_trees behaviour that knows its `path`
Node = Any
C = TypeVar("C", bound=py_trees.composites.Composite)


class Substitutes(Protocol):
    """What may stand in for nodes of an unedited tree, by path."""

    def node(self, path: str, part: Part, builder: Builder) -> Node | None:
        """Return a stand-in for the node at this path, or None."""
        ...

    def condition(self, path: str, builder: Builder) -> Callable[[], bool] | None:
        """Return a stand-in for the condition at this path, or None."""
        ...


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


def build(program: Program, context: Context, substitutes: Substitutes | None = None) -> BuiltTree:
    """Build the main tree of a checked program; touches no device."""
    return Builder(program, context, substitutes).main()


@dataclass(slots=True)
class _Frame:
    """The cells of one use of a tree."""

    signature: Signature
    path: str
    cells: dict[str, Cell] = field(default_factory=dict)

    @property
    def scope(self) -> TreeScope:
        return TreeScope(self.signature)


class _Computed(Cell):
    """An input fed by an expression: worked out at each read."""

    __slots__ = ("thunk",)

    def __init__(self, name: str, thunk: Callable[[], Any]) -> None:
        super().__init__(name)
        self.thunk = thunk

    def read(self) -> Any:
        return self.thunk()


def _tee(target: Cell, target_sd: Cell) -> Cell:
    """Return an output whose standard deviation goes to a key of its own."""

    def pass_on(cell: Cell) -> None:
        if cell.value is MISSING:
            for key in (target, target_sd):
                key.unset(cell.writer)
            return
        target.write(cell.value if cell.sd is None else Estimate(cell.value, cell.sd), cell.writer)
        if cell.sd is None:
            raise NodeError(cell.writer, f"${target_sd.name} takes a standard deviation, and the node gave none")
        target_sd.write(cell.sd, cell.writer)

    made = Cell(target.name)
    made.listener = pass_on
    return made


class Builder:
    """Builds one tree; parts call it back for their children, cells and inputs."""

    def __init__(self, program: Program, context: Context, substitutes: Substitutes | None) -> None:
        self.program = program
        self.context = context
        self.substitutes = substitutes
        self.paths = Paths()
        self.nodes: dict[str, Node] = {}
        self.cells: list[Cell] = []
        self.devices: set[str] = set()
        self.readings: set[str] = set()
        self.frame = _Frame(program.main.signature, "main")

    def main(self) -> BuiltTree:
        """Build the main tree."""
        body = self.program.main
        self.own_cells(self.frame, [*body.signature.keys.values(), *body.signature.outs.values()])
        root = self.root(body.part, "main")
        finish = self.root(body.finish, "main/finally") if body.finish else None
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
        """Return the cells that a part writes, by port."""
        if isinstance(part, Leaf):
            types = part.info.outputs
        elif isinstance(part, Call):
            types = {name: d.type for name, d in part.target.outs.items()}
        else:
            return {}
        return {port: (self.cell(key), types[port]) for port, (key, _) in part.outputs.items()}

    # --- cells and inputs

    def cell(self, key: str) -> Cell:
        """Return the cell of a key of the present tree."""
        return self.frame.cells[key]

    def own_cells(self, frame: _Frame, declared: list[Declared]) -> list[tuple[Cell, Any]]:
        """Add fresh cells to a frame and return them with their defaults."""
        fresh = []
        for d in declared:
            default = d.default if d.has_default else MISSING
            cell = Cell(f"{frame.path}/{d.name}", default)
            frame.cells[d.name] = cell
            fresh.append((cell, default))
            self.cells.append(cell)
        return fresh

    def thunk(self, wire: Wire) -> Callable[[], Any]:
        """Return a callable that gives the value of a wire now."""
        if wire.is_constant:
            value = wire.value
            return lambda: value
        assert wire.expression is not None
        return bind(wire.expression, self)

    def source(self, parts: tuple[str, ...]) -> tuple[Callable[[], Any], tuple[str, ...]]:
        """Return what reads a name of the present tree, and the attributes left to follow."""
        symbol = self.frame.scope.resolve(parts)
        rest = parts[symbol.used :]
        context = self.context
        if symbol.origin is Origin.KEY:
            return self.frame.cells[symbol.name].read, rest
        if symbol.origin is Origin.SD:
            return self.frame.cells[symbol.name].read_sd, rest
        if symbol.origin is Origin.READING:
            device, _, reading = symbol.name.partition(".")
            self.readings.add(symbol.name)
            return (lambda: context.reading(device, reading)), rest
        if symbol.origin is Origin.TASK:
            return ((lambda: context.time) if parts[1] == "time" else (lambda: context.ticks)), rest
        return (lambda: symbol.value), rest

    def key_of(self, wire: Wire) -> tuple[Cell, tuple[str, ...]] | None:
        """Return the cell, and the attributes left to follow, of a wire that is a key as it is; else None."""
        if not isinstance(wire.expression, Name):
            return None
        symbol = self.frame.scope.resolve(wire.expression.parts)
        if symbol.origin is not Origin.KEY:
            return None
        return self.frame.cells[symbol.name], wire.expression.parts[symbol.used :]

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
        with own_code(path, f"{part.info.cls.__name__}()"):
            node = made(part.info.cls, path)
        node.path = path
        node.context = self.context
        node.device_names = dict(part.devices)
        self.devices.update(part.devices.values())
        for declared in part.info.of(Role.INPUT):
            wire = part.inputs.get(declared.name)
            thunk = self.thunk(wire or Wire(part.mark, value=declared.default))
            bounded = wire is not None and not wire.is_constant and (declared.min, declared.max) != (None, None)
            node.wiring[declared.name] = _bounded(thunk, declared, part.info.types[declared.name]) if bounded else thunk
        for declared in part.info.of(Role.OUTPUT):
            cell = self.cell(part.outputs[declared.name][0]) if declared.name in part.outputs else Cell(declared.name)
            sd = part.outputs.get(f"{declared.name}_sd")
            if sd is not None and f"{declared.name}_sd" not in part.info.ports:
                cell = _tee(cell, self.cell(sd[0]))
            node.sinks[declared.name] = cell
        return node

    def call(self, part: Call, path: str) -> CallNode:
        """Build a called tree with cells of its own."""
        body = self.program.body(part.target)
        frame = _Frame(part.target, path)
        for declared in part.target.ins.values():
            frame.cells[declared.name] = self.input_cell(declared, part.inputs.get(declared.name), path)
        private = [d for d in part.target.outs.values() if d.name not in part.outputs]
        for declared in part.target.outs.values():
            if declared.name in part.outputs:
                frame.cells[declared.name] = self.cell(part.outputs[declared.name][0])
        local = self.own_cells(frame, [*part.target.keys.values(), *private])
        outer, self.frame = self.frame, frame
        try:
            child = self.root(body.part, path)
            finish = self.root(body.finish, f"{path}/finally") if body.finish else None
        finally:
            self.frame = outer
        return CallNode(path, child, local, finish)

    def input_cell(self, declared: Declared, wire: Wire | None, path: str) -> Cell:
        """Return the cell of an input: the caller's own, a constant, or one that is worked out at each read."""
        if wire is None:
            return Cell(f"{path}/{declared.name}", declared.default)
        if wire.is_constant:
            return Cell(f"{path}/{declared.name}", wire.value)
        key = wire.single_key()
        if key is not None:
            return self.cell(key)
        return _Computed(f"{path}/{declared.name}", self.thunk(wire))


def _bounded(thunk: Callable[[], Any], declared: Port, type_: Type) -> Callable[[], Any]:
    """Hold what is not known at load against the bounds of its port; the node fails when it is outside."""
    low, high = declared.min, declared.max

    def read() -> Any:
        value = thunk()
        for number in value if isinstance(value, list) else (value,):
            if number is not None and not within(number, low, high):
                raise NoAnswer(f"{declared.name}: {outside(number, type_.item or type_, low, high)}")
        return value

    return read
