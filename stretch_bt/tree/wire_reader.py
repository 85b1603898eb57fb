"""From the wires of a tree to functions that read its cells, readings and params while it runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.errors import Absent
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.context import Context
from stretch_bt.tree.document import Signature
from stretch_bt.tree.expression import bind
from stretch_bt.tree.expression.parse import Name
from stretch_bt.tree.expression.typecheck import Origin
from stretch_bt.tree.feeds import error_of_field, present
from stretch_bt.tree.flow import Wire
from stretch_bt.tree.scope import TreeScope

__all__ = ["TreeCells", "WireReader"]


@dataclass(slots=True)
class TreeCells:
    """The cells of one use of a tree."""

    signature: Signature
    path: str
    cells: dict[str, Cell] = field(default_factory=dict)
    devices: dict[str, str] = field(default_factory=dict)  # of the task, where the tree calls them otherwise

    @property
    def scope(self) -> TreeScope:
        """What the names of the tree mean."""
        return TreeScope(self.signature)


class WireReader:
    """Gives functions that read the wires of the tree whose frame is present."""

    def __init__(self, context: Context, frame: TreeCells) -> None:
        self.context = context
        self.frame = frame
        #: readings in expressions, as `arm.force`
        self.readings: set[str] = set()

    def cell(self, key: str) -> Cell:
        """Return the cell of a key of the present tree."""
        return self.frame.cells[key]

    def default(self, key: str) -> Any:
        """Return the default of a key of the present tree."""
        declared = self.frame.signature.declared(key)
        return declared.default if declared is not None and declared.has_default else MISSING

    def thunk(self, wire: Wire) -> Callable[[], Any]:
        """Return a callable that gives the value of a wire now."""
        if wire.is_constant:
            value = wire.value
            return lambda: value
        assert wire.expression is not None
        return bind(wire.expression, self)

    def thunk_or_none(self, wire: Wire) -> Callable[[], Any]:
        """Return a function that gives the value of a wire, or None where the wire is only a name that holds nothing."""
        thunk = self.thunk(wire)
        return present(thunk, None, (Absent,)) if isinstance(wire.source, Name) and not wire.is_constant else thunk

    def source(self, parts: tuple[str, ...]) -> tuple[Callable[[], Any], tuple[str, ...]]:
        """Return a function that reads a name of the present tree, and the attributes left to follow."""
        symbol = self.frame.scope.resolve(parts)
        rest = parts[symbol.used :]
        context = self.context
        if symbol.origin is Origin.KEY:
            return self.frame.cells[symbol.name].read, rest
        if symbol.origin is Origin.SD:
            return self.frame.cells[symbol.name].read_sd, rest
        if symbol.origin is Origin.READING:
            device, _, reading = symbol.name.partition(".")
            device = self.frame.devices.get(device, device)
            self.readings.add(f"{device}.{reading}")
            return (lambda: context.reading(device, reading)), rest
        if symbol.origin is Origin.TASK:
            return ((lambda: context.time) if parts[1] == "time" else (lambda: context.ticks)), rest
        return symbol.read, rest

    def key_of(self, wire: Wire) -> tuple[Cell, tuple[str, ...]] | None:
        """Return the cell, and the attributes left to follow, of a wire that is a key as it is; else None."""
        if not isinstance(wire.expression, Name):
            return None
        symbol = self.frame.scope.resolve(wire.expression.parts)
        if symbol.origin is not Origin.KEY:
            return None
        return self.frame.cells[symbol.name], wire.expression.parts[symbol.used :]

    def error_of(self, wire: Wire) -> Callable[[], float | None] | None:
        """Return what reads the error of a wire's value; None where a value of its kind carries none."""
        if wire.source is None:
            return None
        if not isinstance(wire.source, Name):
            value = bind(wire.source, self)
            return lambda: getattr(value(), "sd", None)
        symbol = self.frame.scope.resolve(wire.source.parts)
        rest = wire.source.parts[symbol.used :]
        if symbol.origin is Origin.PARAM and not rest:
            beside = self.frame.signature.document.params.get(f"{symbol.name}_sd")
            return None if beside is None else lambda: beside.value
        if symbol.origin is not Origin.KEY:
            return None
        cell = self.frame.cells[symbol.name]
        return cell.error if not rest else lambda: error_of_field(cell, rest)
