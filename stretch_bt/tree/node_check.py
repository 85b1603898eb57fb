"""What a class must keep to so that it can be a node."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.hardware.limits import LIMITED
from stretch_bt.hardware.measured_by import QUANTITIES
from stretch_bt.source import did_you_mean
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.declared_ports import RegistryError
from stretch_bt.tree.node_info import snake_case
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.types import Family, Type, attributes, from_annotation
from stretch_bt.units import KINDS, Estimate

__all__ = ["check_class", "check_constructor", "check_port", "port_types"]

#: methods of a node that a tick or a run calls and does not wait for
_METHODS = ("prepare", "initialise", "update", "terminate")
#: methods that no node may override, and the method to override instead
_KEPT = {"tick": "update()", "stop": "terminate()"}
_OF_MOTION = ("start", "watch", "arrived")  # of a node that moves, which its base class has


def check_class(cls: Any) -> None:
    """Check that a class is one of nodes and overrides only what it may; raises RegistryError."""
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


def check_constructor(name: str, cls: type[Behavior]) -> None:
    """Check that a class is made from a path alone; raises RegistryError."""
    try:
        inspect.signature(cls).bind("main/path")
    except TypeError as error:
        raise RegistryError(
            f"node {name!r}: its __init__ does not take a path alone ({error}); write __init__(self, path='')"
        ) from None


def check_port(name: str, declared: Port, type_: Type, ports: Mapping[str, Port]) -> None:
    """Check bounds, limit, truth and default of a port of a node; raises RegistryError."""
    _check_bounds(name, declared)
    _check_limit(name, declared)
    _check_truth(name, declared, type_)
    _check_default(name, declared, ports)


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
    where, of_object = f"node {name!r}, port {declared.name!r}", _attributes(type_)
    compared = {"": type_, **of_object}
    for of, quantity in declared.truth.items():
        if of not in compared:
            hint = did_you_mean(of, sorted(of_object)) if of_object else f"write truth={quantity!r}"
            raise RegistryError(f"{where}: the output has no attribute {of!r}; {hint}")
        _check_kind(where, of, compared[of], quantity)


def _attributes(type_: Type) -> Mapping[str, Type]:
    return attributes(type_.cls) if type_.family is Family.OBJECT and type_.cls is not None else {}


def _check_kind(where: str, of: str, type_: Type, quantity: str) -> None:
    """Check that a value may be compared with a quantity of the scene."""
    what = f"its {of!r}" if of else "the port"
    if not type_.is_number:
        numbers = [name for name, found in _attributes(type_).items() if found.is_number]
        hint = "leave the truth out"
        if numbers:
            hint = f"write the attribute that is compared, as in truth={{{numbers[0]!r}: {quantity!r}}}"
        raise RegistryError(f"{where}: {what} is of type {type_}, but its truth {quantity!r} is a number; {hint}")
    kind = QUANTITIES.get(quantity)
    if kind is not None and type_.family is Family.QUANTITY and type_.dimension != KINDS[kind].dimension:
        raise RegistryError(
            f"{where}: {what} is a {type_}, but {quantity!r} is a {kind}; write the name of a quantity that is a {type_}"
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


def port_types(cls: type[Behavior]) -> dict[str, Type]:
    """Return the types of the ports of a class; raises RegistryError for a port that the language cannot type."""
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
