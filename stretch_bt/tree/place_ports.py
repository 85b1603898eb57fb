"""The ports of a node, or of a tree that is called, at a place of a tree, before any of them is wired."""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass

from stretch_bt.source import Scalar, Value, is_nothing
from stretch_bt.tree.document import Declared, Document, Signature
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.places import Place
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.types import Family, Type

__all__ = ["PlacePort", "PlacePorts", "Ports"]


@dataclass(frozen=True, slots=True)
class PlacePort:
    """A port of a node, or of a tree that is called, as far as its border goes."""

    type: Type
    min: float | None = None
    max: float | None = None
    needed: bool = True
    declared: Port | Declared | None = None


@dataclass(frozen=True, slots=True)
class Ports:
    """What a place is given, what it gives, and which of these it reads and writes over."""

    inputs: dict[str, PlacePort]
    outputs: dict[str, Type]
    over: Container[str]


def _of_tree(tree: Signature) -> Ports:
    borders = (*tree.ins.values(), *tree.inouts.values())
    given = {d.name: PlacePort(d.type, d.min, d.max, not d.has_default, d) for d in borders}
    taken = {d.name: d.type for d in (*tree.outs.values(), *tree.inouts.values())}
    return Ports(given, taken | {name: out.type for name, out in tree.deviations.items()}, tree.inouts)


def _of_node(info: NodeInfo) -> Ports:
    given = {
        p.name: PlacePort(info.types[p.name], p.min, p.max, p.required, p)
        for p in (*info.of(Role.INPUT), *info.of(Role.INOUT))
    }
    return Ports(given, info.outputs | info.inouts, info.inouts)


class PlacePorts:
    """Finds the ports of places of one file; the ports of each node once, since most nodes stand at many places."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.nodes: dict[str, Ports] = {}

    def at(self, place: Place) -> Ports:
        """Return the ports of a place."""
        word = place.word.text
        target = self.document.tree(word)
        if target is not None:
            return _of_tree(target)
        if word not in self.nodes:
            info = self.document.node(word)
            self.nodes[word] = Ports({}, {}, ()) if info is None else _of_node(info)
        return self.nodes[word]

    def reached(self, place: Place, name: str) -> Iterator[PlacePort]:
        """Yield each input port of a place that a name is wired to as it is."""
        for port, given in self.at(place).inputs.items():
            value = place.given.get(port)
            if value is None:
                if port == name and given.type.is_record:
                    yield given
            elif (is_nothing(value) and port == name) or _is_just(value, name, given.type):
                yield given


def _is_just(value: Value, name: str, type_: Type) -> bool:
    """Whether the value given to a port is a name as it is, `$x` or `x`; where text is wanted, `x` is that text."""
    if not isinstance(value, Scalar):
        return False
    return value.text == f"${name}" or (value.text == name and type_.family not in (Family.STR, Family.ENUM))
