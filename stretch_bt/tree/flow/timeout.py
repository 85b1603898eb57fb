"""A bound on time, on the run's own clock."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Mark, Value
from stretch_bt.tree.countdown import Countdown
from stretch_bt.tree.flow.base import Flow, FlowNode, Known, Part, Wire, construct
from stretch_bt.tree.fragments import Schema, form, ref
from stretch_bt.tree.types import quantity
from stretch_bt.units import KINDS

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.context import Context
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["Timeout", "TimeoutNode"]

TIME = quantity(KINDS["Time"].dimension)


@construct
@dataclass(slots=True)
class Timeout(Part):
    """FAILURE when `do` still runs at the tick that finds `after` over; it is interrupted, not waited for."""

    after: Wire
    do: Part
    keyword: ClassVar[str] = "timeout"

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read `{after, do}`."""
        fields = reader.fields(value, mark, "timeout", required=("after", "do"))
        if fields is None:
            return None
        after = reader.value(fields["after"], TIME, "timeout.after", low=0.0)
        do = reader.body(fields["do"])
        return cls(mark, after, do) if after and do else None

    @classmethod
    def around(cls, reader: Reader, part: Part, value: Value) -> Part:
        """Read the `timeout` written beside a node."""
        after = reader.value(value, TIME, "timeout", low=0.0)
        return cls(value.mark, after, part, name=f"{part.label}:timeout", beside=True) if after else part

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return form({"after": ref("input_Time"), "do": ref("body")})

    @classmethod
    def schema_beside(cls) -> Schema:
        """Return the schema of its word beside a node."""
        return ref("input_Time")

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {"after": self.after.text}

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """It may fail at any time, so nothing is known then."""
        data.read((self.after,), known)
        return Flow(self.do.flow(data, known).success, known)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the guard on time."""
        return TimeoutNode(path, builder.child(self, self.do, path), builder.thunk(self.after), builder.context)


class TimeoutNode(FlowNode):
    """Asks the clock before it ticks the child, so a late child is never called a success."""

    def __init__(
        self, path: str, child: py_trees.behaviour.Behaviour, after: Callable[[], float], context: Context
    ) -> None:
        super().__init__(path, child)
        self.after = after
        self.context = context

    def begin(self) -> None:
        """Start the time."""
        self.time = Countdown(self.context, self.after())

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Tick the child while there is time."""
        if self.status is Status.RUNNING and self.time.over:
            doing = getattr(self.child.tip(), "path", self.child.name)
            self.feedback_message = f"out of time while {doing} was running"
            return Status.FAILURE
        yield from self.child.tick()
        return self.child.status
