"""Shipped trees that a body may call like a node, without an import."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from stretch_bt.source import Map, Scalar, Seq, Value

__all__ = ["SHARED", "shared_trees", "shipped"]

#: trees, and the files that hold them
SHARED = {"approach": "lib/press.yaml", "press_gently": "lib/press.yaml"}


def shipped(name: str) -> Path:
    """Return the path of a file among the shipped trees."""
    return Path(str(files("stretch_bt") / "trees" / name))


def shared_trees(bodies: list[Map]) -> list[str]:
    """Return which of them some bodies may call."""
    found = {word for body in bodies for word in _words(body)}
    return [name for name in SHARED if name in found]


def _words(value: Value) -> Iterator[str]:
    if isinstance(value, Map):
        for key, inner in value:
            yield key.text
            yield from _words(inner)
    elif isinstance(value, Seq):
        for item in value.items:
            yield from _words(item)
    elif isinstance(value, Scalar):
        yield value.text
