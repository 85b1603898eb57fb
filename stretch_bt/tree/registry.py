"""The nodes that tree files may name: the nodes of this package, of installed packages, and of imported modules."""

from __future__ import annotations

import importlib
import importlib.metadata
import sys
from collections.abc import Container, Iterable
from contextlib import redirect_stdout
from functools import cache
from importlib.util import find_spec
from pkgutil import iter_modules
from typing import Any, TypeVar

from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.declared_ports import RegistryError
from stretch_bt.tree.node_check import check_class, check_constructor, check_port, port_types
from stretch_bt.tree.node_info import NodeInfo, snake_case
from stretch_bt.tree.port import Role
from stretch_bt.tree.types import Family, Type, attributes

__all__ = [
    "RESERVED",
    "RETIRED",
    "RegistryError",
    "find",
    "forget",
    "known",
    "load_all",
    "lookup",
    "node",
    "object_types",
    "take_again",
]

GROUP = "stretch_bt.nodes"
#: name of the node library, which stands above this module
BUILTIN = "stretch_bt.behaviors"

#: words that a tree may put beside the ports of any node
RESERVED = ("name", "doc", "timeout", "retry", "guard", "skip_if", "finally", "log")
#: such words of older files, and how they are spelt now
RETIRED = {"while": "guard"}

B = TypeVar("B", bound=type[Behavior])
#: result of `@node()`, which is refused when it is executed
_NO_CLASS: Any = None


_nodes: dict[str, NodeInfo] = {}


def node(cls: B = _NO_CLASS, /) -> B:
    """Register a node class under its name in snake case; use it as a decorator.

    Raises
    ------
    RegistryError
        The class has no docstring, a port that the language cannot type, or a name that is taken.
    """
    if cls is _NO_CLASS:
        raise RegistryError("@node has parentheses; write '@node' alone above the class")
    check_class(cls)
    name = snake_case(cls.__name__)
    info = NodeInfo(name, cls, cls.ports, port_types(cls))
    if not (cls.__doc__ or "").strip():
        raise RegistryError(f"node {name!r} ({cls.__module__}) has no docstring; one sentence says what it does")
    for declared in cls.ports.values():
        if declared.name in RESERVED:
            raise RegistryError(f"node {name!r}: a port cannot be called {declared.name!r}; the word is reserved")
        check_port(name, declared, info.types[declared.name], cls.ports)
    check_constructor(name, cls)
    _keep(info)
    return cls


def _keep(info: NodeInfo) -> None:
    name, cls = info.name, info.cls
    present = _nodes.get(name) if cls.__module__ == f"{BUILTIN}.{name}" else _shipped(name)
    if present is not None and (present.cls.__module__, present.cls.__qualname__) != (cls.__module__, cls.__qualname__):
        raise RegistryError(f"node {name!r} of {cls.__module__} is already registered by {present.cls.__module__}")
    _nodes[name] = info


@cache
def _library() -> frozenset[str]:
    """Return the names of the modules of the node library; the module of a node has the node's name."""
    package = find_spec(BUILTIN)
    places = package.submodule_search_locations if package is not None else None
    return frozenset(module.name for module in iter_modules(places) if not module.name.startswith("_"))


@cache
def _import_library() -> None:
    for name in sorted(_library()):
        importlib.import_module(f"{BUILTIN}.{name}")


@cache
def _import_installed() -> None:
    """Import the installed packages that offer nodes."""
    for entry in sorted(importlib.metadata.entry_points(group=GROUP), key=lambda e: e.name):
        try:
            with redirect_stdout(sys.stderr):  # output is the command's alone
                entry.load()
        except RegistryError:
            raise
        except Exception as error:
            raise RegistryError(f"the nodes of {entry.value!r} cannot be imported: {error}") from error


def load_all() -> dict[str, NodeInfo]:
    """Return every registered node by name; imports the node library and the packages that offer nodes, once."""
    _import_library()
    _import_installed()
    return dict(sorted(_nodes.items()))


def known() -> dict[str, NodeInfo]:
    """Return the nodes registered so far by name; imports nothing."""
    return dict(_nodes)


def forget(names: Iterable[str]) -> None:
    """Take nodes of own modules out of the registry."""
    for name in names:
        del _nodes[name]


def take_again(nodes: Iterable[NodeInfo]) -> None:
    """Register nodes that were forgotten; raises RegistryError for a name that another one has."""
    for info in nodes:
        _keep(info)


def _shipped(name: str) -> NodeInfo | None:
    """Return the node of the library of this name, or None; no other one is imported."""
    if name not in _nodes and name in _library():
        importlib.import_module(f"{BUILTIN}.{name}")
    return _nodes.get(name)


def lookup(name: str) -> NodeInfo | None:
    """Return the node of this name, or None; of the library no other one is imported."""
    found = _shipped(name)
    if found is None:
        _import_installed()
    return found or _nodes.get(name)


def find(name: str, modules: Container[str]) -> NodeInfo | None:
    """Return a node, also one written with the name of the module that it was imported under."""
    found = lookup(name)
    prefix, dot, last = name.rpartition(".")
    return lookup(last) if found is None and dot and prefix in modules else found


def object_types(more: Iterable[NodeInfo] = ()) -> dict[str, type]:
    """Return the classes that ports carry, of the nodes of the registry and of `more`, by the name that files use for them."""
    found: dict[str, type] = {}

    def add(type_: Type) -> None:
        if type_.family is Family.LIST and type_.item is not None:
            add(type_.item)
        elif type_.cls is not None and type_.name not in found:
            found[type_.name] = type_.cls
            for attribute in attributes(type_.cls).values():
                add(attribute)

    for info in (*load_all().values(), *more):
        for declared in info.ports.values():
            if declared.role is not Role.DEVICE:
                add(info.types[declared.name])
    return found
