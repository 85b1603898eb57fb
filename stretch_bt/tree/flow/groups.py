"""Sequences and selectors: with memory, or reactive (every child before the running one is asked again each tick)."""

from __future__ import annotations

from collections.abc import Sequence as SequenceOf
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import py_trees

from stretch_bt.source import Mark, Value
from stretch_bt.tree.flow.base import Flow, Known, Part, construct
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


@dataclass(slots=True)
class _SequenceBase(Group):
    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Each child knows what all before it wrote."""
        failure: Known | None = None
        success: Known | None = known
        for part in self.parts:
            if success is None:
                data.diagnostics.append(
                    part.mark.error(
                        "unreachable",
                        f"{part.label!r} is never reached",
                        "the part before it cannot succeed; remove one",
                    )
                )
                break
            ends = part.flow(data, success)
            success = ends.success
            if ends.failure is not None:
                failure = ends.failure if failure is None else failure & ends.failure
        return Flow(success, failure)


@dataclass(slots=True)
class _SelectorBase(Group):
    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Each child knows only what was written before a failure; one of them succeeded at the end."""
        success: Known | None = None
        failure: Known | None = known
        for part in self.parts:
            if failure is None:
                data.diagnostics.append(
                    part.mark.error(
                        "unreachable", f"{part.label!r} is never reached", "the part before it cannot fail; remove one"
                    )
                )
                break
            ends = part.flow(data, failure)
            failure = ends.failure
            if ends.success is not None:
                success = ends.success if success is None else success & ends.success
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
