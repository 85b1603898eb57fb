"""Literals that reach a port through a key: one that a `set` or a loop alone writes is held against the bounds of the port."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Mark
from stretch_bt.tree.flow import Call, Leaf, Part
from stretch_bt.tree.flow.base import Wire
from stretch_bt.tree.flow.for_each import ForEach
from stretch_bt.tree.flow.set_keys import SetKeys
from stretch_bt.tree.tree_body import TreeBody
from stretch_bt.tree.types import Type
from stretch_bt.tree.values import ValueRefused, check_bounds

__all__ = ["known_values"]


def known_values(body: TreeBody) -> Iterator[Diagnostic]:
    """Yield a warning for each literal that is outside the bounds of a port to which its key goes; a condition may keep it from there."""
    parts = list(body.parts())
    written = {key: values for part in parts for key, values in _written(part) if len(body.writers[key]) == 1}
    for part in parts:
        for wire, type_, low, high, what in _bounded(part):
            for value, mark in written.get(wire.single_key() or "", ()):
                try:
                    check_bounds(value, type_, low, high, mark, what)
                except ValueRefused as refused:
                    yield replace(refused.diagnostic, severity="warning")


def _written(part: Part) -> Iterator[tuple[str, list[tuple[Any, Mark]]]]:
    """Yield each key to which a part gives values that are known at load, with these and their places."""
    if isinstance(part, SetKeys):
        for key, wire in part.wires.items():
            if wire.is_constant and wire.value is not None:
                yield key, [(wire.value, wire.mark)]
    elif isinstance(part, ForEach) and part.items.is_constant:
        values = part.items.value
        yield part.key, list(zip(values, part.items.items or [part.items.mark] * len(values), strict=True))


def _bounded(part: Part) -> Iterator[tuple[Wire, Type, float | None, float | None, str]]:
    """Yield what feeds each input of a node or a call, with the type, the bounds and the name of the port."""
    if isinstance(part, Leaf):
        for name, wire in part.inputs.items():
            port = part.info.ports[name]
            yield wire, part.info.types[name], port.min, port.max, f"{part.label}.{name}"
    elif isinstance(part, Call):
        for name, wire in part.inputs.items():
            declared = part.target.ins[name]
            yield wire, declared.type, declared.min, declared.max, f"{part.label}.{name}"
