"""A place that could not be read; it keeps one mistake from being reported again as its consequences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import py_trees

from stretch_bt.errors import NodeError
from stretch_bt.source import Mark
from stretch_bt.tree.flow.base import Flow, Known, Part

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow

__all__ = ["Broken"]


@dataclass(slots=True)
class Broken(Part):
    """Stands for whatever was meant: it may succeed or fail, and writes every key that it names."""

    word: str
    parts: list[Part] = field(default_factory=list)
    keys: dict[str, Mark] = field(default_factory=dict)
    keyword: ClassVar[str] = "broken"
    transparent: ClassVar[bool] = True

    @property
    def label(self) -> str:
        """The given name, or what stands there."""
        return self.name or self.word

    def children(self) -> Sequence[Part]:
        """Return what could be read inside."""
        return self.parts

    def is_long(self) -> bool:
        """Nothing is known against it."""
        return False

    def own_writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield every key that it names."""
        yield from ((key, self.label, mark) for key, mark in self.keys.items())

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Whatever it names is taken to be written, before anything inside is run."""
        after = known | set(self.keys)
        for part in self.parts:
            after |= part.flow(data, after).success or set()
        return Flow(after, known)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Refuse: a tree with an error is not built."""
        raise NodeError(path, "this place was not understood; check the file")
