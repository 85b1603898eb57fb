"""So many times: `repeat` until all passes succeeded, `retry` until one did."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Mark, Value
from stretch_bt.tree.flow.base import Flow, FlowNode, Known, Part, Wire, both, construct, why_failed
from stretch_bt.tree.flow.count import counted, read_count, runs_surely
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
    counter: ClassVar[str] = ""

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    def is_long(self) -> bool:
        """Each pass begins in a tick of its own."""
        return True

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read the count, which is mandatory, and `do`."""
        fields = reader.fields(value, mark, cls.keyword, required=("do",), bound=(cls.counter, 3))
        if fields is None:
            return None
        count = read_count(reader, fields[cls.counter], f"{cls.keyword}.{cls.counter}")
        do = reader.body(fields["do"])
        return cls(mark, count, do) if count and do else None

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return form({cls.counter: ref("count"), "do": ref("body")})

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {self.counter: self.count.text}

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """What a pass writes is surely there where at least one is run."""
        data.read((self.count,), known)
        passed = self.do.flow(data, known)
        return passed if runs_surely(self.count) else self.without_pass(passed, known)

    def without_pass(self, passed: Flow, known: Known) -> Flow:
        """Return what is known where perhaps no pass is run: a success that nothing wrote for."""
        return Flow(both(passed.success, known), passed.failure)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the loop."""
        again = Status.SUCCESS if self.keyword == "repeat" else Status.FAILURE
        return CountedNode(path, builder.child(self, self.do, path), builder.thunk(self.count), self.counter, again)


@construct
@dataclass(slots=True)
class Repeat(_Counted):
    """Run `do` `times` times; FAILURE at the first that fails."""

    keyword: ClassVar[str] = "repeat"
    counter: ClassVar[str] = "times"


@construct
@dataclass(slots=True)
class Retry(_Counted):
    """Run `do` up to `attempts` times in all, until it succeeds."""

    keyword: ClassVar[str] = "retry"
    counter: ClassVar[str] = "attempts"

    def without_pass(self, passed: Flow, known: Known) -> Flow:
        """Return what is known where perhaps no attempt is made: a failure that nothing wrote for."""
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


class CountedNode(FlowNode):
    """Starts the child again after each end with `again`, one start per tick, `count` times in all; `counter` is its word for that."""

    def __init__(
        self, path: str, child: py_trees.behaviour.Behaviour, count: Callable[[], int], counter: str, again: Status
    ) -> None:
        super().__init__(path, child)
        self.count = count
        self.counter = counter
        self.again = again
        self.passes = 0

    def begin(self) -> None:
        """Count from the start."""
        self.passes = 0

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Tick the child; go on while it ends with `again` and passes are left."""
        if self.status is not Status.RUNNING and counted(self.count, self.path, self.counter) == 0:
            self.feedback_message = f"{self.counter} is 0"
            return self.again
        yield from self.child.tick()
        status = self.child.status
        if status is not self.again:
            return status
        self.passes += 1
        if self.passes < self.count():
            return Status.RUNNING
        if status is Status.FAILURE:
            self.feedback_message = f"{self.passes} attempts failed, the last at {why_failed(self.child)}"
        return status
