"""Which values of Python a tree file can write: by their annotation, with the type of the language that stands for it."""

from __future__ import annotations

import collections.abc
import types
import typing
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import py_trees

from stretch_bt.units import Kind

__all__ = ["Written", "mentions_behaviour", "shown_annotation", "written_as"]

_UNIONS = (typing.Union, types.UnionType)
_LISTS: dict[Any, Callable[[Any], Any]] = {
    list: list,
    tuple: tuple,
    set: set,
    frozenset: frozenset,
    collections.abc.Sequence: list,
    collections.abc.Iterable: list,
    collections.abc.Collection: list,
}


def _same(value: Any) -> Any:
    return value


@dataclass(frozen=True, slots=True)
class Written:
    """How a tree file writes a value: as which annotation of a port, and what makes Python's value of it and back."""

    annotation: Any
    made: Callable[[Any], Any] = _same
    back: Callable[[Any], Any] = _same


def written_as(annotation: Any) -> Written | None:
    """Return how a tree file writes values of this annotation; None where it cannot."""
    origin, members = typing.get_origin(annotation), typing.get_args(annotation)
    if annotation in (Any, object):
        return Written(Any)
    if origin is Annotated:
        quantity = any(isinstance(part, Kind) for part in members[1:])
        return Written(annotation, float) if quantity else written_as(members[0])
    if origin in _UNIONS:
        return _union(members)
    if origin is typing.Literal:
        return Written(annotation) if all(isinstance(member, str | int) for member in members) else None
    if origin in _LISTS:
        return _list(_LISTS[origin], members)
    if annotation in (
        bool,
        int,
        float,
        str,
    ):  # a number may come with its error, which Python's isinstance does not ask for
        return Written(annotation, annotation)
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        names = typing.Literal[tuple(annotation.__members__)]  # type: ignore[valid-type]
        return Written(names, annotation.__getitem__, lambda member: member.name)
    return Written(str, Path, str) if annotation is Path else None


def _union(members: tuple[Any, ...]) -> Written | None:
    """Return how one of several is written: as the only one that can be, else as any plain value."""
    rest = [member for member in members if member is not type(None)]
    known = [found for member in rest if (found := written_as(member)) is not None]
    if not known:
        return None
    one = Written(float, float) if set(rest) == {int, float} else known[0] if len(known) == 1 else Written(Any)
    if len(rest) == len(members) or one.annotation is Any:
        return one
    return Written(
        typing.Optional[one.annotation],  # noqa: UP045  # an annotation that is known only now
        lambda value: None if value is None else one.made(value),
        lambda value: None if value is None else one.back(value),
    )


def _list(make: Callable[[Any], Any], members: tuple[Any, ...]) -> Written | None:
    """Return how a list is written whose items are all alike."""
    kinds = set(members) - {...}
    item = written_as(kinds.pop()) if len(kinds) == 1 else None
    if item is None or item.annotation is Any:
        return None
    inner = item
    return Written(
        list[inner.annotation],  # type: ignore[name-defined]
        lambda values: make(inner.made(value) for value in values),
        lambda values: [inner.back(value) for value in values],
    )


def mentions_behaviour(annotation: Any) -> bool:
    """Whether an annotation asks for a behaviour, or a list of them."""
    if isinstance(annotation, type) and not typing.get_args(annotation):
        return issubclass(annotation, py_trees.behaviour.Behaviour)
    return any(mentions_behaviour(part) for part in typing.get_args(annotation) if not isinstance(part, list))


def shown_annotation(annotation: Any) -> str:
    """Return an annotation as its source may have it."""
    if isinstance(annotation, str):
        return annotation
    plain = isinstance(annotation, type) and not typing.get_args(annotation)
    text = annotation.__qualname__ if plain else str(annotation)
    return text.replace("typing.", "").replace("collections.abc.", "").replace("NoneType", "None").replace("~", "")
