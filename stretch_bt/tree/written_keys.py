"""Which keys a part of a tree writes."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.source import Mark
from stretch_bt.tree.flow import Broken, Call, Leaf, Part
from stretch_bt.tree.flow.for_each import ForEach
from stretch_bt.tree.flow.repeat import Repeat
from stretch_bt.tree.flow.set_keys import SetKeys
from stretch_bt.tree.flow.until import Until

__all__ = ["written_keys"]


def written_keys(part: Part) -> Iterator[tuple[str, str, Mark]]:
    """Yield every key that a part writes, with who writes it and where."""
    for inner in part.walk():
        if isinstance(inner, Leaf | Call):
            for key, mark in (*inner.outputs.values(), *inner.inouts.values()):
                yield key, inner.label, mark
        elif isinstance(inner, SetKeys):
            for key, mark in inner.marks.items():
                yield key, "set", mark
        elif isinstance(inner, ForEach):
            yield inner.key, "for_each", inner.key_mark
            yield from ((key, "for_each", mark) for key, mark in inner.passes.marks.items())
        elif isinstance(inner, Until | Repeat):
            yield from ((key, inner.keyword, mark) for key, mark in inner.passes.marks.items())
        elif isinstance(inner, Broken):
            for key, mark in inner.keys.items():
                yield key, inner.label, mark
