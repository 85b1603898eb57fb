"""The nodes that tree files may name: the nodes of this package, of installed packages, and of imported modules."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.metadata
import inspect
import math
import re
import sys
from collections.abc import Container, Iterable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pkgutil import iter_modules
from typing import Any, TypeVar

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.hardware.limits import LIMITED
from stretch_bt.source import did_you_mean
from stretch_bt.source.comments import comments_of
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.declared_ports import RegistryError
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.port_check import PortCheck
from stretch_bt.tree.types import Family, Type, attributes, from_annotation
from stretch_bt.units import Estimate

__all__ = [
    "RESERVED",
    "RETIRED",
    "NodeInfo",
    "RegistryError",
    "describe",
    "fields_of",
    "find",
    "first_paragraph",
    "forget",
    "known",
    "load_all",
    "lookup",
    "node",
    "object_types",
    "records_of",
    "take_again",
]

GROUP = "stretch_bt.nodes"
#: name of the node library, which stands above this module
BUILTIN = "stretch_bt.behaviors"

#: words that a tree may put beside the ports of any node
RESERVED = ("name", "doc", "timeout", "retry", "guard", "skip_if", "finally", "log")
#: such words of older files, and how they are spelt now
RETIRED = {"while": "guard"}

#: methods of a node that a tick or a run calls and does not wait for
_METHODS = ("prepare", "initialise", "update", "terminate")
#: methods that no node may override, and the method to override instead
_KEPT = {"tick": "update()", "stop": "terminate()"}
_OF_MOTION = ("start", "watch", "arrived")  # of a node that moves, which its base class has

B = TypeVar("B", bound=type[Behavior])
#: result of `@node()`, which is refused when it is executed
_NO_CLASS: Any = None


@dataclass(frozen=True)
class NodeInfo:
    """A registered node: its YAML name, its class and its ports with their types."""

    name: str
    cls: type[Behavior]
    ports: dict[str, Port]
    types: dict[str, Type]

    @property
    def doc(self) -> str:
        """The first paragraph of the class docstring."""
        return first_paragraph(self.cls.__doc__)

    @property
    def instant(self) -> bool:
        """Whether the node always ends in the tick it starts."""
        return bool(self.cls.instant)

    def of(self, role: Role) -> list[Port]:
        """Return the ports of one role, in the order of the class."""
        return [p for p in self.ports.values() if p.role is role]

    @property
    def inouts(self) -> dict[str, Type]:
        """Types of the ports that are read and written."""
        return {declared.name: self.types[declared.name] for declared in self.of(Role.INOUT)}

    @property
    def outputs(self) -> dict[str, Type]:
        """Types of the output ports; each quantity also writes `<name>_sd`."""
        found: dict[str, Type] = {}
        for declared in self.of(Role.OUTPUT):
            found[declared.name] = self.types[declared.name]
            if self.types[declared.name].is_number and f"{declared.name}_sd" not in self.ports:
                found[f"{declared.name}_sd"] = self.types[declared.name]
        return found

    def written(self) -> dict[str, PortCheck]:
        """Return what each value that the node writes must be, deviations of its outputs included."""
        ports = {name: port.check(self.ports) for name, port in self.ports.items() if port.written}
        return {name: PortCheck(float, 0.0, None) for name in self.outputs} | ports


_nodes: dict[str, NodeInfo] = {}


def snake_case(name: str) -> str:
    """Return the YAML name of a class name."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


def node(cls: B = _NO_CLASS, /) -> B:
    """Register a node class under its name in snake case; use it as a decorator.

    Raises
    ------
    RegistryError
        The class has no docstring, a port that the language cannot type, or a name that is taken.
    """
    if cls is _NO_CLASS:
        raise RegistryError("@node has parentheses; write '@node' alone above the class")
    _check_class(cls)
    name = snake_case(cls.__name__)
    info = NodeInfo(name, cls, cls.ports, _port_types(cls))
    if not (cls.__doc__ or "").strip():
        raise RegistryError(f"node {name!r} ({cls.__module__}) has no docstring; one sentence says what it does")
    for declared in cls.ports.values():
        if declared.name in RESERVED:
            raise RegistryError(f"node {name!r}: a port cannot be called {declared.name!r}; the word is reserved")
        _check_bounds(name, declared)
        _check_limit(name, declared)
        _check_truth(name, declared, info.types[declared.name])
        _check_default(name, declared, cls.ports)
    try:
        inspect.signature(cls).bind("main/path")
    except TypeError as error:
        raise RegistryError(
            f"node {name!r}: its __init__ does not take a path alone ({error}); write __init__(self, path='')"
        ) from None
    _keep(info)
    return cls


def _keep(info: NodeInfo) -> None:
    name, cls = info.name, info.cls
    present = _nodes.get(name) if cls.__module__ == f"{BUILTIN}.{name}" else _shipped(name)
    if present is not None and (present.cls.__module__, present.cls.__qualname__) != (cls.__module__, cls.__qualname__):
        raise RegistryError(f"node {name!r} of {cls.__module__} is already registered by {present.cls.__module__}")
    _nodes[name] = info


def _check_class(cls: Any) -> None:
    if not (isinstance(cls, type) and issubclass(cls, Behavior)):
        what = getattr(cls, "__name__", type(cls).__name__)
        raise RegistryError(f"@node stands above {what!r}, which is no class of nodes; write class {what}(Behavior)")
    for method, instead in _KEPT.items():
        if getattr(cls, method) is not getattr(Behavior, method):
            raise RegistryError(
                f"node {snake_case(cls.__name__)!r}: {method}() belongs to the framework, which stops and records by it; write {instead}"
            )
    methods = [*_METHODS, *(name for name in _OF_MOTION if any(name in vars(base) for base in cls.__mro__[1:]))]
    for method in methods:
        made = getattr(cls, method, None)
        if inspect.iscoroutinefunction(made) or inspect.isgeneratorfunction(made) or inspect.isasyncgenfunction(made):
            form = "async" if not inspect.isgeneratorfunction(made) else "a generator"
            raise RegistryError(
                f"node {snake_case(cls.__name__)!r}: {method}() is {form}, so its code would not run when it is called;"
                f" write a plain 'def {method}' without await or yield"
            )


def _check_bounds(name: str, declared: Port) -> None:
    ends = [end for end in (declared.min, declared.max) if end is not None]
    numbers = all(isinstance(end, int | float) and math.isfinite(end) for end in ends)
    if not numbers or ends != sorted(ends):
        raise RegistryError(
            f"node {name!r}, port {declared.name!r}: its bounds are {declared.min!r} and {declared.max!r}; "
            "write SI numbers, the smaller as 'min'"
        )


def _check_limit(name: str, declared: Port) -> None:
    if declared.limit is not None and declared.limit not in LIMITED:
        hint = did_you_mean(str(declared.limit), LIMITED)
        message = f"node {name!r}, port {declared.name!r}: no cell has a limit {declared.limit!r}"
        raise RegistryError(f"{message}; {hint or 'write one of ' + ', '.join(LIMITED)}")


def _check_truth(name: str, declared: Port, type_: Type) -> None:
    known = {"", *(attributes(type_.cls) if type_.family is Family.OBJECT and type_.cls is not None else ())}
    for wrong in declared.truth.keys() - known:
        hint = did_you_mean(wrong, sorted(known - {""})) or "write the attribute of the output that is compared"
        raise RegistryError(
            f"node {name!r}, port {declared.name!r}: its truth is of {wrong!r}, which it has not; {hint}"
        )


def _check_default(name: str, declared: Port, ports: Mapping[str, Port]) -> None:
    if declared.role is not Role.INPUT or declared.default is MISSING:
        return
    try:
        declared.check(ports).judge(declared.default)
    except InvalidInput as error:
        raise RegistryError(f"node {name!r}, port {declared.name!r}: its default is wrong: {error}") from None
    if isinstance(declared.default, Estimate) and f"{declared.name}_sd" in ports:
        message = f"node {name!r}, port {declared.name!r}: the deviation of its default would be lost beside a port {declared.name}_sd"
        raise RegistryError(f"{message}; write {float(declared.default):g}, and {declared.default.sd:g} as that port's")


def _port_types(cls: type[Behavior]) -> dict[str, Type]:
    found = {}
    for declared in cls.ports.values():
        if declared.role is Role.DEVICE and declared.annotation not in INTERFACES.values():
            raise RegistryError(
                f"node {snake_case(cls.__name__)!r}, port {declared.name!r}: it uses no device of a cell; "
                f"write Uses[D] or Uses[D | None], D one of {', '.join(INTERFACES)}"
            )
        try:
            found[declared.name] = from_annotation(declared.annotation)
        except TypeError as error:
            raise RegistryError(f"node {snake_case(cls.__name__)!r}, port {declared.name!r}: {error}") from None
    return found


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


def first_paragraph(text: str | None) -> str:
    """Return the first paragraph of a docstring on one line, nothing without one."""
    return " ".join((text or "").strip().split("\n\n")[0].split())


def describe(info: NodeInfo) -> dict[str, Any]:
    """Return what `nodes --json` prints of a node."""
    return {
        "name": info.name,
        "kind": info.cls.kind,
        "doc": info.doc,
        "module": info.cls.__module__,
        "inputs": [_describe_port(info, p) for p in info.of(Role.INPUT)],
        "outputs": [_describe_output(info, name, type_) for name, type_ in info.outputs.items()],
        "inouts": [_describe_port(info, p) for p in info.of(Role.INOUT)],
        "devices": [
            {"name": p.name, "type": info.types[p.name].name, "required": not p.optional} for p in info.of(Role.DEVICE)
        ],
        "records": records_of(info.types[p.name] for p in info.ports.values() if p.role is not Role.DEVICE),
    }


def records_of(types: Iterable[Type]) -> dict[str, list[dict[str, Any]]]:
    """Return the fields of the records among some types, by the name of the type."""
    classes = {(type_.item or type_).name: (type_.item or type_).cls for type_ in types if type_.is_record}
    return {name: fields_of(cls) for name, cls in classes.items() if cls is not None}


def _describe_port(info: NodeInfo, declared: Port) -> dict[str, Any]:
    type_ = info.types[declared.name]
    kind = type_.kind
    entry = {
        "name": declared.name,
        "type": type_.name,
        "unit": kind.si_unit if kind else None,
        "default": _plain_default(declared.default),
        "required": declared.required,
        "doc": declared.doc,
    }
    bounds = {"min": declared.min, "max": declared.max}
    return entry | {k: v for k, v in bounds.items() if v is not None}


def _describe_output(info: NodeInfo, name: str, type_: Type) -> dict[str, Any]:
    declared = info.ports.get(name)
    doc = declared.doc if declared else f"standard deviation of {name.removesuffix('_sd')}"
    return {"name": name, "type": type_.name, "unit": type_.kind.si_unit if type_.kind else None,
            "default": None, "required": False, "doc": doc}  # fmt: skip


def fields_of(cls: type) -> list[dict[str, Any]]:
    """Return what expressions may read of a record: name, type, unit and doc of each field."""
    docs = comments_of(cls)
    return [
        {
            "name": name,
            "type": type_.name,
            "unit": type_.kind.si_unit if type_.kind else None,
            "doc": docs.get(name) or (inspect.getdoc(getattr(cls, name, None)) or "").partition("\n")[0],
        }
        for name, type_ in attributes(cls).items()
    ]


def _plain_default(default: Any) -> Any:
    if default is MISSING:
        return None
    if isinstance(default, Estimate) or dataclasses.is_dataclass(default):
        return repr(default)
    return list(default) if isinstance(default, tuple) else default
