"""The ports that a class of behaviours declares as `INPUT_PORTS` and `OUTPUT_PORTS`, as py_trees has them from 2.6 on."""

from __future__ import annotations

import typing
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.foreign.refused import BehaviourRefused
from stretch_bt.tree.foreign.written import Written, shown_annotation, written_as
from stretch_bt.tree.port import Port, Role

__all__ = ["ClassPort", "class_ports", "has_ports"]

_REMEDY = (
    "write a subclass whose port is a number, a text, a list of these or a class, or a node of your own with @node"
)


@dataclass(frozen=True, slots=True)
class ClassPort:
    """A declared port, and how its values go between the tree and the behaviour."""

    port: Port
    written: Written


def class_ports(cls: type) -> list[ClassPort]:
    """Return the ports that a class declares; none where it declares none, or an older py_trees knows none."""
    found = [_port(cls, name, about, Role.INPUT) for name, about in _table(cls, "INPUT_PORTS").items()]
    found += [_port(cls, name, about, Role.OUTPUT) for name, about in _table(cls, "OUTPUT_PORTS").items()]
    return [port for port in found if port is not None]


def has_ports(cls: type) -> bool:
    """Whether a class has what reads and writes declared ports; without, they are names that nothing uses."""
    return callable(getattr(cls, "setup_ports", None))


def _table(cls: type, name: str) -> Mapping[str, Any]:
    table = getattr(cls, name, None) if has_ports(cls) else None
    return table if isinstance(table, Mapping) else {}


def _port(cls: type, name: str, about: Any, role: Role) -> ClassPort | None:
    """Return one port; None for an input that may be left out and that no tree can give."""
    type_, required, default = about.data_type, bool(about.required), about.default_value
    written = _written(type_)
    if written is None:
        if role is Role.INPUT and not (required and default is None):
            return None
        message = f"{cls.__qualname__} has a port {name!r} of type {shown_annotation(type_)}, which no tree can wire"
        raise BehaviourRefused(message, _REMEDY)
    annotation = written.annotation if required or default is not None else typing.Optional[written.annotation]  # noqa: UP045
    given: Any = MISSING
    if role is Role.INPUT and default is not None:
        given = written.back(default)
    elif role is Role.INPUT and not required:
        given = None
    return ClassPort(Port(name, role, annotation, given, told=str(about.description or "")), written)


def _written(type_: Any) -> Written | None:
    """Return how values of a port's type go through keys: written in the file, or as an object of a class."""
    written = written_as(type_)
    if written is None and isinstance(type_, type) and not typing.get_args(type_):
        return Written(type_)
    return None if written is None or written.annotation is Any else written
