"""Shipped trees that a body may call like a node, without an import."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from importlib.resources import files
from pathlib import Path

from stretch_bt.source import Map, Mark, Scalar, Value, walk

__all__ = ["SHARED", "reachable", "shared_trees", "shipped"]

#: trees, and the files that hold them
SHARED = {"approach": "lib/press.yaml", "press_gently": "lib/press.yaml"}


def shipped(name: str) -> Path:
    """Return the path of a file among the shipped trees."""
    return Path(str(files("stretch_bt") / "trees" / name))


def shared_trees(bodies: Iterable[Map]) -> dict[str, Mark]:
    """Return which of them some bodies may call, and where first."""
    found: dict[str, Mark] = {}
    for word in (word for body in bodies for word in _words(body)):
        if word.text in SHARED:
            found.setdefault(word.text, word.mark)
    return found


def reachable(bodies: Mapping[str, Map], begun: Iterable[str]) -> set[str]:
    """Return the trees of a file, given by their bodies, that some of them may call, themselves among them."""
    found: set[str] = set()
    ahead = [name for name in begun if name in bodies]
    while ahead:
        name = ahead.pop()
        if name not in found:
            found.add(name)
            ahead += [word.text for word in _words(bodies[name]) if word.text in bodies]
    return found


def _words(body: Value) -> Iterator[Scalar]:
    for key, value in walk(body):
        if key is not None:
            yield key
        if isinstance(value, Scalar):
            yield value
