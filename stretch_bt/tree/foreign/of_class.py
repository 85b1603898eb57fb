"""The node that a class of py_trees or of another package gives, or why it gives none."""

from __future__ import annotations

import inspect
import sys
from dataclasses import replace
from functools import cache
from typing import Any

import py_trees

from stretch_bt.tree import registry
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.foreign.arguments import Argument, arguments_of, takes_name
from stretch_bt.tree.foreign.class_ports import ClassPort, class_ports, has_ports
from stretch_bt.tree.foreign.node import ForeignNode, Made
from stretch_bt.tree.foreign.refused import BehaviourRefused
from stretch_bt.tree.foreign.written import mentions_behaviour, shown_annotation
from stretch_bt.tree.node_info import NodeInfo, first_paragraph, snake_case
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.slots import bit, slot
from stretch_bt.tree.types import ANY, Type, from_annotation

__all__ = ["class_in", "classes_in", "info_of"]

#: constructs of the language for behaviours that hold others
CONSTRUCTS = {
    "Sequence": "sequence",
    "Selector": "selector",
    "Parallel": "parallel",
    "Inverter": "invert",
    "Retry": "retry",
    "Repeat": "repeat",
    "Timeout": "timeout",
    "EternalGuard": "guard",
    "ForEach": "for_each",
    "FailureIsSuccess": "force_success",
    "SuccessIsFailure": "force_failure",
}


def info_of(cls: type, name: str = "") -> NodeInfo:
    """Return the node that a class gives, under a name or the name of the class.

    Raises
    ------
    BehaviourRefused
        It is no class of behaviours, or asks for what a tree file cannot write.
    """
    name = name or snake_case(cls.__name__)
    if issubclass(cls, Behavior):
        return _own(cls, name)
    if not issubclass(cls, py_trees.behaviour.Behaviour):
        message = f"{cls.__qualname__} is a class, but none of behaviours: it does not derive from py_trees' Behaviour"
        raise BehaviourRefused(message, "name a class of behaviours, or a module")
    node, types = _node_of(cls)
    return NodeInfo(name, node, node.ports, types)


def class_in(module: str, name: str) -> type | None:
    """Return a class by its dotted name in a module that was imported, or None."""
    found: Any = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return found if isinstance(found, type) else None


def classes_in(module: str) -> list[str]:
    """Return the names of the classes of behaviours in a module that was imported."""
    found = vars(sys.modules[module]) if module in sys.modules else {}
    base = py_trees.behaviour.Behaviour
    return [name for name, cls in found.items() if isinstance(cls, type) and issubclass(cls, base)]


def _own(cls: type[Behavior], name: str) -> NodeInfo:
    known = registry.lookup(snake_case(cls.__name__))
    if known is None or known.cls is not cls:
        raise BehaviourRefused(f"{cls.__qualname__} is a node that is not registered", "put @node above its class")
    return replace(known, name=name)


@cache
def _node_of(cls: type) -> tuple[type[ForeignNode], dict[str, Type]]:
    """Return the class of nodes that tick behaviours of a class, and the types of its ports."""
    _check_made(cls)
    declared, arguments = class_ports(cls), arguments_of(cls)
    _check_children(cls, arguments)
    taken = {found.port.name for found in declared}
    arguments = [argument for argument in arguments if argument.name not in taken]
    _check_written(cls, arguments)
    usable = [argument for argument in arguments if argument.written is not None]
    node = _new_class(cls, declared, usable)
    return node, {name: _type_of(port.annotation) for name, port in node.ports.items()}


def _new_class(cls: Any, declared: list[ClassPort], arguments: list[Argument]) -> type[ForeignNode]:
    ports = {argument.name: _port(argument) for argument in arguments} | {
        found.port.name: found.port for found in declared
    }
    doc = first_paragraph(cls.__doc__) or f"{cls.__module__}.{cls.__qualname__}, which has no docstring."
    node: Any = type(cls.__name__, (ForeignNode,), {"__module__": cls.__module__, "__doc__": doc})
    node.ports = ports
    # no attributes of the node, which may be called alike
    node.slots = {name: slot(port, ports) for name, port in ports.items() if port.written}
    owed = [port for port in ports.values() if port.written and not port.check({}).optional]
    node.owed = node._required = sum(bit(port.name, ports) for port in owed)
    node.instant = getattr(cls, "instant", False) is True
    written = {a.name: a.written for a in arguments if a.written is not None}
    node.made = Made(cls, takes_name(cls), written, {found.port.name: found.written for found in declared})
    made: type[ForeignNode] = node
    return made


def _port(argument: Argument) -> Port:
    """Return a constructor argument as a port; the class keeps a default that no file can write to itself."""
    assert argument.written is not None
    annotation, default = argument.written.annotation, argument.default
    if argument.required:
        default = MISSING
    else:
        try:
            default = None if default is None else argument.written.back(default)
            Port(argument.name, Role.INPUT, annotation).check({}).judge(default)
        except Exception:  # whatever a default of another type makes of it
            default = None
    return Port(argument.name, Role.INPUT, annotation, default, told=argument.doc, fixed=True)


def _type_of(annotation: Any) -> Type:
    try:
        return from_annotation(annotation)
    except TypeError:  # of any value
        return ANY


def _check_made(cls: type) -> None:
    if inspect.isabstract(cls):
        missing = ", ".join(sorted(cls.__abstractmethods__))  # type: ignore[attr-defined]
        raise BehaviourRefused(
            f"{cls.__qualname__} is abstract: it lacks {missing}", "name a class that derives from it"
        )
    if has_ports(cls) and not (hasattr(cls, "INPUT_PORTS") and hasattr(cls, "OUTPUT_PORTS")):
        what = f"{cls.__qualname__} is abstract: it lacks INPUT_PORTS and OUTPUT_PORTS"
        raise BehaviourRefused(what, "name a class that derives from it and has both")


def _check_children(cls: type, arguments: list[Argument]) -> None:
    """Refuse what holds other behaviours, as composites and decorators do: a tree file gives none as an argument."""
    for argument in arguments:
        if mentions_behaviour(argument.annotation):
            what = f"{cls.__qualname__} holds other behaviours: its argument {argument.name!r} takes "
            word = CONSTRUCTS.get(cls.__name__) if cls.__module__.partition(".")[0] == "py_trees" else None
            hint = (
                f"use {word!r} of the language"
                if word
                else "use the language's own constructs, or write a class of your own"
            )
            raise BehaviourRefused(what + shown_annotation(argument.annotation), hint)


def _check_written(cls: type, arguments: list[Argument]) -> None:
    """Refuse a class that needs what no tree file can write."""
    for argument in arguments:
        if not argument.required or argument.written is not None:
            continue
        of = (
            f"of type {shown_annotation(argument.annotation)}"
            if argument.annotation is not inspect.Parameter.empty
            else ""
        )
        what = f"{cls.__qualname__} needs {argument.name!r} {of or 'without a type'}, which no tree file can write"
        remedy = f"write a subclass that gives {argument.name!r} a value, or a node of your own with @node"
        raise BehaviourRefused(what, remedy if of else f"annotate it, or {remedy}")
