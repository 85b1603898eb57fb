"""Outputs of a run, with their standard deviations, beside what the scene knew at the moment each was found."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from stretch_bt.errors import NoAnswer
from stretch_bt.hardware.measured_by import QUANTITIES
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.source import MISSPELT, closest
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.document import Declared
from stretch_bt.tree.flow.call import CallNode
from stretch_bt.tree.flow.set_keys import Copy, SetKeysNode
from stretch_bt.tree.port import Port
from stretch_bt.tree.series import errors_of
from stretch_bt.units import parse_unit

__all__ = ["Truths", "output_values"]

Known = Mapping[str, float]  # by the attribute of a value that it belongs to; of the value itself by ""


@dataclass(frozen=True, slots=True)
class _Found:
    """What a key holds, and what the scene knew of it when a node found it."""

    value: Any
    known: Known


class Truths(Onlooker):
    """A watcher that asks the scene for the truth whenever a node writes a port that declares one, for an output.

    A `set` that passes a value on passes on its truth; whatever else writes a key leaves it without one. What the scene alone knows
    is asked for whenever an output is written. The last write counts.
    """

    def __init__(self, built: BuiltTree, truth: Callable[[], Mapping[str, float]]) -> None:
        self.names = {cell.name: name for name, (_, cell) in built.outputs.items()}
        self.own = [name for name, (declared, _) in built.outputs.items() if declared.scene]
        self.truth = truth
        beyond = _reached(built)
        self.copies = {(node.path, key): copy for node, cell, copy in _copies(built) for key in beyond(cell)}
        wanted = _leading_to(set(self.names), self.copies)
        self.ports = {
            (node.path, key): (node, port)
            for node, cell, port in _ports(built)
            for key in beyond(cell)
            if key in wanted
        }
        self.held: dict[str, _Found] = {}
        self.of_scene: dict[str, float] = {}
        self.misspelt: dict[tuple[str, str], str] = {}

    @property
    def found(self) -> dict[str, float]:
        """What the scene knew of each output."""
        held = {name: self.held[key].known[""] for key, name in self.names.items() if "" in self._known(key)}
        return held | self.of_scene

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Ask for the truth of what a node found, or take over what was known where it came from."""
        truths, copy = self._declared(path, key), self.copies.get((path, key))
        asked = self._asked() if truths or (self.own and key in self.names and value is not None) else {}
        known: Known = {}
        if truths:
            known = {of: asked[name] for of, name in truths.items() if name in asked}
            self._look_for_slips(path, truths, asked)
        elif copy is not None:
            known = self._passed_on(copy, value)
        self.held.pop(key, None)
        if known and value is not None:
            self.held[key] = _Found(value, known)
        if key in self.names:
            self.of_scene |= {name: asked[name] for name in self.own if name in asked}

    @property
    def notes(self) -> list[str]:
        """What is likely misspelt: a truth that a port declares, and that the scene knows by another name."""
        return [
            f"{path}: the scene knows no {name!r}, which a port declares as its truth; did you mean {meant!r}?"
            for (path, name), meant in sorted(self.misspelt.items())
        ]

    def _look_for_slips(self, path: str, truths: Mapping[str, str], asked: Known) -> None:
        """Keep each truth that a node declares, that is of no shipped scene, and that this scene nearly knows."""
        for name in set(truths.values()) - asked.keys() - QUANTITIES.keys():
            meant = closest(name, asked, MISSPELT)
            if meant is not None:
                self.misspelt[path, name] = meant

    def _declared(self, path: str, key: str) -> Mapping[str, str]:
        """Return the truths that the port declares which a node has just written, unless it says that they are not of this value."""
        found = self.ports.get((path, key))
        if found is None:
            return {}
        node, port = found
        return {} if port.name in node.untold else port.truth

    def _known(self, key: str) -> Known:
        return self.held[key].known if key in self.held else {}

    def _asked(self) -> dict[str, float]:
        """Return what the scene knows now; nothing where it has no answer for how the hand stands."""
        try:
            return {name: value for name, value in self.truth().items() if math.isfinite(value)}
        except NoAnswer:
            return {}

    def _passed_on(self, copy: Copy, value: Any) -> Known:
        """Return what is known of a value that a `set` took from another key, if that still holds what a node found."""
        source = self.held.get(copy.cell.name)
        if source is None or not (_same(copy.cell.value, source.value) and _same(copy.follow(source.value), value)):
            return {}
        attribute = ".".join(copy.attributes)
        if attribute:
            return {"": source.known[attribute]} if attribute in source.known else {}
        return source.known


def _same(one: Any, other: Any) -> bool:
    return one is other or (isinstance(one, int | float) and isinstance(other, int | float) and one == other)


def _reached(built: BuiltTree) -> Callable[[str], set[str]]:
    """Return what tells the keys that a value reaches from the one it is written to: itself, and those that called trees hand it on to."""
    handed: dict[str, set[str]] = {}
    for node in built.nodes.values():
        if isinstance(node, CallNode):
            for inner, outer in node.handed_on():
                handed.setdefault(inner.name, set()).add(outer.name)

    def reached(key: str) -> set[str]:
        return {key}.union(*(reached(outer) for outer in handed.get(key, ())))

    return reached


def _ports(built: BuiltTree) -> Iterator[tuple[Behavior, str, Port]]:
    """Yield each output of a node that declares truths, with its key."""
    for node in built.nodes.values():
        if isinstance(node, Behavior):
            for name, port in node.ports.items():
                if port.truth and name in node.sinks:
                    yield node, node.sinks[name].name, port


def _copies(built: BuiltTree) -> Iterator[tuple[SetKeysNode, str, Copy]]:
    """Yield each key that a `set` only copies from another."""
    for node in built.nodes.values():
        if isinstance(node, SetKeysNode):
            for cell, copy in node.copies.items():
                yield node, cell, copy


def _leading_to(outputs: set[str], copies: Mapping[tuple[str, str], Copy]) -> set[str]:
    """Return the outputs and the keys from which one is copied, over whatever others."""
    wanted, before = outputs, set[str]()
    while wanted != before:
        before, wanted = wanted, wanted | {copy.cell.name for (_, to), copy in copies.items() if to in wanted}
    return wanted


def output_values(
    outputs: Mapping[str, tuple[Declared, Cell]], truths: Mapping[str, float], *, succeeded: bool
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (outputs, truth) as {name: {value, unit, sd}}, in the unit that each is shown in.

    A default that nothing overwrote is an output of a task that `succeeded` alone.
    """
    values, known = {}, {}
    for name, (declared, cell) in outputs.items():
        unit, scale = shown_in(declared)
        if declared.scene and name in truths:
            values[name] = {"value": _scaled(truths[name], scale), "unit": unit, "sd": None}
        elif cell.value is not MISSING and (succeeded or cell.writer):
            sd = cell.sd if cell.sd is not None else _of_entries(cell.value)
            values[name] = {"value": _scaled(cell.value, scale), "unit": unit, "sd": _scaled(sd, scale)}
        if name in truths:
            known[name] = {"value": _scaled(truths[name], scale), "unit": unit, "sd": None}
    return values, known


def _of_entries(value: Any) -> list[float | None] | None:
    """Return the standard deviations of a list that a loop collected; None where no entry has one."""
    found = list(errors_of(value)) if isinstance(value, list) else []
    return found if any(sd is not None for sd in found) else None


def shown_in(declared: Declared) -> tuple[str, float]:
    """Return the unit that an output, or each entry of one, is shown in, and its SI value."""
    kind = (declared.type.item or declared.type).kind
    unit = declared.unit or (kind.unit if kind else "")
    return unit, parse_unit(unit)[0] if unit else 1.0


def _scaled(value: Any, scale: float) -> Any:
    if isinstance(value, list):
        return [_scaled(item, scale) for item in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return value if scale == 1.0 else value / scale
