"""A note in the log of the run when a node ends."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Scalar, Value
from stretch_bt.tree.flow.base import Flow, FlowNode, Known, Part, both
from stretch_bt.tree.flow.text import Text, read_text
from stretch_bt.tree.fragments import Schema

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["Log", "LogNode"]


@dataclass(slots=True)
class Log(Part):
    """Passes on what the body does, and says so in the log when it ends."""

    text: Text
    do: Part
    keyword: ClassVar[str] = "log"
    transparent: ClassVar[bool] = True

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    @classmethod
    def around(cls, reader: Reader, part: Part, value: Value) -> Part:
        """Read the `log` beside a body: a text."""
        if isinstance(value, Scalar) and value.text:
            return cls(value.mark, read_text(reader, value), part, name=f"{part.label}:log", beside=True)
        reader.error(value.mark, "type-mismatch", "'log' takes text", "write 'log: felt the top'")
        return part

    @classmethod
    def schema_beside(cls) -> Schema:
        """Return the schema of its word beside a node."""
        return {"type": "string", "minLength": 1}

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {"text": self.text.written}

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """It changes nothing; the text is read when the body has ended, perhaps by a failure."""
        ends = self.do.flow(data, known)
        data.read(self.text.wires, both(ends.success, ends.failure) or known)
        return ends

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the node."""
        return LogNode(path, builder.child(self, self.do, path), self.text.bind(builder))


class LogNode(FlowNode):
    """Its feedback message reaches the log with the change of status, and is no reason of a failure."""

    explains: ClassVar[bool] = False

    def __init__(self, path: str, child: py_trees.behaviour.Behaviour, text: Callable[[], str]) -> None:
        super().__init__(path, child)
        self.text = text

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Tick the child."""
        yield from self.child.tick()
        if self.child.status is not Status.RUNNING:
            self.feedback_message = self.text()
        return self.child.status
