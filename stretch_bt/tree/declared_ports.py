"""Reads the ports of a node class from its annotations, and refuses wrong ones."""

from __future__ import annotations

import inspect
import re
import types
import typing
from collections.abc import Callable, Mapping, Set
from typing import Annotated, Any

from stretch_bt.errors import StretchError
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.port import Options, Port, Role
from stretch_bt.tree.types import unaliased

__all__ = ["NAME", "PortError", "RegistryError", "declared_ports"]

#: names that a port may have
NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)


class RegistryError(StretchError):
    """A node class cannot be registered; the text says why."""


class PortError(RegistryError, TypeError):
    """A port of a node class is declared wrongly; the text says why."""


def declared_ports(cls: type, taken: Callable[[], Set[str]]) -> dict[str, Port]:
    """Return the ports that the class itself declares; raises PortError. A port cannot have a name of `taken`."""
    annotations = inspect.get_annotations(cls)
    if not annotations:
        return {}
    hints = typing.get_type_hints(cls, include_extras=True, localns={cls.__name__: cls})
    ports = {}
    for name in annotations:
        role, annotation, optional = _split(hints[name])
        if role is not None:
            _check_name(cls, name, taken())
            ports[name] = _make_port(cls, name, role, annotation, optional)
    return ports


def _check_name(cls: type, name: str, taken: Set[str]) -> None:
    if name in taken:
        raise PortError(
            f"{cls.__name__}: a port cannot be called {name!r}; the word is reserved: every node has it; write {name}_"
        )
    if not NAME.fullmatch(name):
        raise PortError(f"{cls.__name__}: a port cannot be called {name!r}; use letters a to z, digits and _ inside")


def _make_port(cls: type, name: str, role: Role, annotation: Any, optional: bool) -> Port:
    given = cls.__dict__.get(name, MISSING)
    options = given if isinstance(given, Options) else Options(given, None, None, "")
    if role is not Role.INPUT and options.default is not MISSING:
        raise PortError(f"{cls.__name__}.{name}: only an input port can have a default")
    truth = _truth(cls, name, role, options.truth)
    return Port(
        name,
        role,
        annotation,
        options.default,
        options.min,
        options.max,
        options.doc,
        optional,
        cls,
        options.limit,
        truth,
    )


def _truth(cls: type, name: str, role: Role, given: Any) -> Mapping[str, str]:
    """Return the quantities of a scene by the attribute of the output that each is compared with, "" for the output itself."""
    if given is None:
        return {}
    if role is not Role.OUTPUT:
        raise PortError(f"{cls.__name__}.{name}: only an output port can have a truth")
    named = {"": given} if isinstance(given, str) else given
    words = [*named.values(), *(() if named is not given else named)] if isinstance(named, Mapping) else []
    if not words or not all(isinstance(word, str) and word.isidentifier() for word in words):
        raise PortError(
            f"{cls.__name__}.{name}: its truth is {given!r}; write the name of a quantity that a scene knows, such as 'deflection',"
            " or a mapping from attributes of the output to such names"
        )
    return dict(named)


def _split(hint: Any) -> tuple[Role | None, Any, bool]:
    """Return the role of an annotation, the annotation without it, and whether None is allowed for a device."""
    if typing.get_origin(hint) is not Annotated:
        return None, hint, False
    base, *metadata = typing.get_args(hint)
    roles = [m for m in metadata if isinstance(m, Role)]
    if not roles:
        return None, hint, False
    rest = tuple(m for m in metadata if not isinstance(m, Role))
    base, optional = unaliased(base), False
    if roles[0] is Role.DEVICE and typing.get_origin(base) in (typing.Union, types.UnionType):
        members = [a for a in typing.get_args(base) if a is not type(None)]
        optional = len(members) < len(typing.get_args(base))
        base = members[0] if len(members) == 1 else base  # the registry refuses the others
    return roles[0], Annotated[(base, *rest)] if rest else base, optional
