"""So many times: `repeat` until all passes succeeded, `retry` until one did."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Mark, Value
from stretch_bt.tree.flow.base import Flow, Known, Part, Wire, both, construct, why_failed
from stretch_bt.tree.flow.count import read_count, runs_surely
from stretch_bt.tree.flow.counted_passes import CountedPasses
from stretch_bt.tree.flow.passes import FIELDS, Passes, passes_schema
from stretch_bt.tree.fragments import Schema, form, ref

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["CountedNode", "Repeat", "Retry"]


@dataclass(slots=True)
class _Counted(Part):
    count: Wire
    do: Part
    passes: Passes = field(default_factory=Passes)
    counter: ClassVar[str] = ""
    more: ClassVar[tuple[str, ...]] = ()  # fields that are optional

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    def is_long(self) -> bool:
        """Each pass begins in a tick of its own."""
        return True

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read the count, which is mandatory, and `do`."""
        fields = reader.fields(value, mark, cls.keyword, required=("do",), optional=cls.more, bound=(cls.counter, 3))
        if fields is None:
            return None
        count = read_count(reader, fields[cls.counter], f"{cls.keyword}.{cls.counter}")
        do = reader.body(fields["do"])
        return cls(mark, count, do, Passes.read(reader, fields, do)) if count and do else None

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return form({cls.counter: ref("count"), "do": ref("body")}, passes_schema() if cls.more else None)

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {self.counter: self.count.text} | self.passes.written()

    def own_writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield the keys of its passes."""
        yield from ((key, self.keyword, mark) for key, mark in self.passes.marks.items())

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """What a pass writes is surely there where at least one is run."""
        data.read((self.count,), known)
        known = self.passes.begun(data, known)
        passed = self.do.flow(data, known)
        ends = passed if runs_surely(self.count) else self.without_pass(passed, known)
        if self.count.may_lack(data.absent):  # before the first pass
            ends = Flow(ends.success, both(ends.failure, known))
        return self.passes.ends(data, ends, known)

    def without_pass(self, passed: Flow, known: Known) -> Flow:
        """Return the flow where perhaps no pass is run: a success for which nothing was written."""
        return Flow(both(passed.success, known), passed.failure)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the loop."""
        again = Status.SUCCESS if self.keyword == "repeat" else Status.FAILURE
        child, passes = builder.child(self, self.do, path), self.passes.bind(builder, path)
        return CountedNode(path, child, builder.thunk(self.count), self.counter, again, passes)


@construct
@dataclass(slots=True)
class Repeat(_Counted):
    """Run `do` `times` times, a number that is worked out as the loop begins; FAILURE at the first that fails."""

    keyword: ClassVar[str] = "repeat"
    counter: ClassVar[str] = "times"
    more: ClassVar[tuple[str, ...]] = FIELDS


@construct
@dataclass(slots=True)
class Retry(_Counted):
    """Run `do` up to `attempts` times in all, a number that is worked out as the loop begins, until it succeeds."""

    keyword: ClassVar[str] = "retry"
    counter: ClassVar[str] = "attempts"

    def without_pass(self, passed: Flow, known: Known) -> Flow:
        """Return the flow where perhaps no attempt is made: a failure for which nothing was written."""
        return Flow(passed.success, both(passed.failure, known))

    @classmethod
    def around(cls, reader: Reader, part: Part, value: Value) -> Part:
        """Read the `retry` written beside a node: a number of attempts."""
        count = read_count(reader, value, "retry.attempts")
        return cls(value.mark, count, part, name=f"{part.label}:retry", beside=True) if count else part

    @classmethod
    def schema_beside(cls) -> Schema:
        """Return the schema of its word beside a node."""
        return ref("count")


class CountedNode(CountedPasses):
    """Starts the child again after each end with `again`, until as many passes as its bound ended so."""

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Tick the child; go on while it ends with `again` and passes are left."""
        if self.most == 0:
            self.feedback_message = f"{self.counter} is 0"
            return self.again
        status = yield from self.tick_pass()
        if status is not self.again:
            return status
        if self.passes < self.most:
            return Status.RUNNING
        if status is Status.FAILURE:
            self.feedback_message = f"{self.passes} attempts failed, the last at {why_failed(self.child)}"
        return status
