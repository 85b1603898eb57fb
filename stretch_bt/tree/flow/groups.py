"""Sequences and selectors: with memory, or reactive (every child before the running one is asked again each tick)."""

from __future__ import annotations

from collections.abc import Sequence as SequenceOf
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import py_trees

from stretch_bt.source import Mark, Value
from stretch_bt.tree.flow.base import Flow, Known, Part, both, construct
from stretch_bt.tree.fragments import Schema, ref

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["Group", "ReactiveSelector", "ReactiveSequence", "Selector", "Sequence"]


@dataclass(slots=True)
class Group(Part):
    """Children in order."""

    parts: list[Part] = field(default_factory=list)
    transparent: ClassVar[bool] = True
    reactive: ClassVar[bool] = False

    def children(self) -> SequenceOf[Part]:
        """Return the children in order."""
        return self.parts

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read a list of at least one child."""
        return cls(mark, reader.children(value, mark, cls.keyword))

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return ref("children")

    def in_turn(self, data: DataFlow, known: Known, *, after_success: bool) -> tuple[Known | None, Known | None]:
        """Return what is known when every child ended so that the next was asked, and when one ended otherwise."""
        going: Known | None = known
        ended: Known | None = None
        for part in self.parts:
            if going is None:
                hint = f"the part before it cannot {'succeed' if after_success else 'fail'}; remove one"
                data.diagnostics.append(part.mark.error("unreachable", f"{part.label!r} is never reached", hint))
                break
            success, failure = part.flow(data, going)
            going, other = (success, failure) if after_success else (failure, success)
            ended = both(ended, other)
        return going, ended


@dataclass(slots=True)
class _SequenceBase(Group):
    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Each child knows what all before it wrote."""
        success, failure = self.in_turn(data, known, after_success=True)
        return Flow(success, failure)


@dataclass(slots=True)
class _SelectorBase(Group):
    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Each child knows only what was written before a failure; one of them succeeded at the end."""
        failure, success = self.in_turn(data, known, after_success=False)
        return Flow(success, failure)


@construct
@dataclass(slots=True)
class Sequence(_SequenceBase):
    """Children one after another; ends at the first FAILURE."""

    keyword: ClassVar[str] = "sequence"

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return a py_trees Sequence with memory."""
        return builder.group(py_trees.composites.Sequence(path, memory=True), self, path)


@construct
@dataclass(slots=True)
class ReactiveSequence(_SequenceBase):
    """Conditions asked on every tick, and one long action."""

    keyword: ClassVar[str] = "reactive_sequence"
    reactive: ClassVar[bool] = True

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return a py_trees Sequence without memory."""
        return builder.group(py_trees.composites.Sequence(path, memory=False), self, path)


@construct
@dataclass(slots=True)
class Selector(_SelectorBase):
    """Children one after another; ends at the first SUCCESS."""

    keyword: ClassVar[str] = "selector"

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return a py_trees Selector with memory."""
        return builder.group(py_trees.composites.Selector(path, memory=True), self, path)


@construct
@dataclass(slots=True)
class ReactiveSelector(_SelectorBase):
    """Children of falling priority, asked again on every tick."""

    keyword: ClassVar[str] = "reactive_selector"
    reactive: ClassVar[bool] = True

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return a py_trees Selector without memory."""
        return builder.group(py_trees.composites.Selector(path, memory=False), self, path)
