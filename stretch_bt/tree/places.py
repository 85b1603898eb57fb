"""The places of a tree's body as its file has them: who is given what, before anything is read or typed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from stretch_bt.source import Map, Scalar, Seq, Value, is_nothing
from stretch_bt.tree.registry import RESERVED, RETIRED

__all__ = ["Place", "places"]

#: fields of a construct under which places stand
_INSIDE = ("do", "children")
#: constructs after whose colon a node may stand bare, as in `invert: capture`
_AROUND = ("invert", "force_success", "force_failure")


@dataclass(frozen=True, slots=True)
class Place:
    """A node, a call or a construct by its word, with what stands in its braces."""

    word: Scalar
    given: Map


def places(value: Value, is_construct: Callable[[str], bool]) -> Iterator[Place]:
    """Yield every place of a body, in the order of the file; mistakes are passed over."""
    if isinstance(value, Seq):
        for item in value.items:
            yield from places(item, is_construct)
    elif isinstance(value, Scalar):
        if value.text:
            yield Place(value, Map((), value.mark))
    else:
        yield from _in_map(value, is_construct)


def _in_map(value: Map, is_construct: Callable[[str], bool]) -> Iterator[Place]:
    for key, given in value:
        if key.text == "run":
            yield from _called(value, given)
        elif key.text == "finally":
            yield from places(given, is_construct)
        elif is_construct(key.text) and not (key.text in RESERVED and not _is_body(given)):
            yield from _in_construct(key, given, is_construct)
        elif key.text not in (*RESERVED, *RETIRED, "with"):
            yield Place(key, given if isinstance(given, Map) else Map((), key.mark))


def _in_construct(key: Scalar, given: Value, is_construct: Callable[[str], bool]) -> Iterator[Place]:
    """Yield a construct, and the places inside it: all of it is one where it has no field for them, as in `invert: {...}`."""
    yield Place(key, given if isinstance(given, Map) else Map((), key.mark))
    if key.text == "set" or is_nothing(given):
        return
    if isinstance(given, Scalar) and key.text in _AROUND:
        yield from places(given, is_construct)
        return
    fields = [given.get(name) for name in _INSIDE] if isinstance(given, Map) else []
    inside = [field for field in fields if field is not None]
    if inside or not isinstance(given, Map | Seq):
        for field in inside:
            yield from places(field, is_construct)
    elif key.text not in ("check", "fail"):
        yield from places(given, is_construct)


def _is_body(given: Value) -> bool:
    """Whether a reserved word is a construct here, as in `timeout: {after: 1 s, do: ...}`."""
    return isinstance(given, Map) and "do" in given


def _called(beside: Map, given: Value) -> Iterator[Place]:
    """Yield the call of `{run: tree, with: {...}}` and of `run: {tree: ..., with: {...}}`."""
    tree = given.get("tree") if isinstance(given, Map) else given
    ports = (given if isinstance(given, Map) else beside).get("with")
    if isinstance(tree, Scalar):
        yield Place(tree, ports if isinstance(ports, Map) else Map((), tree.mark))
