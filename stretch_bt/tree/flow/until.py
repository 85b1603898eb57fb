"""Repeat until a condition holds, at most so many times."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Mark, Value
from stretch_bt.tree.flow.base import Flow, Known, Part, Wire, both, construct
from stretch_bt.tree.flow.count import read_count, runs_surely
from stretch_bt.tree.flow.counted_passes import CountedPasses
from stretch_bt.tree.flow.passes import FIELDS, Passes, PassKeys, passes_schema
from stretch_bt.tree.fragments import Schema, form, ref
from stretch_bt.tree.types import BOOL

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["Until", "UntilNode"]


@construct
@dataclass(slots=True)
class Until(Part):
    """Run `do`, then ask `that`; SUCCESS when it holds, FAILURE when `do` fails or after `max` passes, worked out as the loop begins."""

    that: Wire
    max: Wire
    do: Part
    passes: Passes
    keyword: ClassVar[str] = "until"

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    def is_long(self) -> bool:
        """Each pass begins in a tick of its own."""
        return True

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read `{that, max, do}`, and `collect` and `keys`; the bound is mandatory."""
        fields = reader.fields(value, mark, "until", required=("that", "do"), optional=FIELDS, bound=("max", 100))
        if fields is None:
            return None
        that = reader.expression(fields["that"], BOOL, "until.that")
        bound = read_count(reader, fields["max"], "until.max")
        do = reader.body(fields["do"])
        passes = Passes.read(reader, fields, do)
        return cls(mark, that, bound, do, passes) if that and bound and do else None

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return form({"that": ref("condition"), "max": ref("count"), "do": ref("body")}, passes_schema())

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {"that": self.that.text, "max": self.max.text} | self.passes.written()

    def own_writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield the keys of its passes."""
        yield from ((key, self.keyword, mark) for key, mark in self.passes.marks.items())

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """The condition is asked after a pass, so it knows what the pass wrote."""
        data.read((self.max,), known)
        known = self.passes.begun(data, known)
        ends = self.do.flow(data, known)
        if ends.success is not None:
            data.read((self.that,), ends.success)
        failure = both(ends.failure, ends.success)
        ends = Flow(ends.success, failure if runs_surely(self.max) else both(failure, known))
        return self.passes.ends(data, ends, known)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the loop."""
        child, passes = builder.child(self, self.do, path), self.passes.bind(builder, path)
        return UntilNode(path, child, builder.thunk(self.that), builder.thunk(self.max), passes)


class UntilNode(CountedPasses):
    """One pass starts per tick; a pass that needs several ticks takes them."""

    def __init__(
        self,
        path: str,
        child: py_trees.behaviour.Behaviour,
        that: Callable[[], bool],
        bound: Callable[[], int],
        keys: PassKeys,
    ) -> None:
        super().__init__(path, child, bound, "max", Status.SUCCESS, keys)
        self.that = that

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Run the body; ask the condition after each pass."""
        if self.most == 0:
            self.feedback_message = "max is 0"
            return Status.FAILURE
        status = yield from self.tick_pass()
        if status is not Status.SUCCESS:
            return status
        if self.that():
            return Status.SUCCESS
        if self.passes >= self.most:
            self.feedback_message = f"the condition still does not hold after {self.passes} passes"
            return Status.FAILURE
        return Status.RUNNING
