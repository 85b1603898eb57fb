"""Changing a result: `invert`, `force_success`, `force_failure`; and `fail`, which ends a branch with a reason."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Mark, Scalar, Value
from stretch_bt.tree.flow.base import Flow, FlowNode, Known, Part, both, construct
from stretch_bt.tree.flow.text import Text, read_text
from stretch_bt.tree.fragments import Schema, ref

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["Fail", "ForceFailure", "ForceSuccess", "Invert", "ResultNode"]


@dataclass(slots=True)
class _Result(Part):
    do: Part
    #: what SUCCESS and FAILURE of the body become
    becomes: ClassVar[dict[Status, Status]] = {}

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read the body: a node, or a list run as a sequence."""
        do = reader.body(value)
        return cls(mark, do) if do else None

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return ref("body")

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Success and failure change places, or fall together."""
        ends = self.do.flow(data, known)
        if self.becomes[Status.SUCCESS] is self.becomes[Status.FAILURE]:
            merged = both(ends.success, ends.failure)
            return Flow(merged, None) if self.becomes[Status.SUCCESS] is Status.SUCCESS else Flow(None, merged)
        return Flow(ends.failure, both(ends.success, ends.failure))  # what has no answer stays FAILURE

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the node around its child."""
        return ResultNode(path, builder.child(self, self.do, path), self.becomes)


class ResultNode(FlowNode):
    """Passes RUNNING on and maps the last status of the child; a FAILURE without an answer is never turned round."""

    def __init__(self, path: str, child: py_trees.behaviour.Behaviour, becomes: dict[Status, Status]) -> None:
        super().__init__(path, child)
        self.becomes = becomes

    @property
    def inverts(self) -> bool:
        """Whether SUCCESS and FAILURE change places."""
        return self.becomes[Status.SUCCESS] is not self.becomes[Status.FAILURE]

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Tick the child and map its status."""
        yield from self.child.tick()
        if self.inverts and (silent := _unanswered(self.child)) is not None:
            self.feedback_message = silent.feedback_message
            return Status.FAILURE
        status = self.becomes.get(self.child.status, self.child.status)
        if status is not self.child.status:
            self.feedback_message = f"{self.child.name} ended with {self.child.status.name}"
        return status


def _unanswered(node: py_trees.behaviour.Behaviour) -> py_trees.behaviour.Behaviour | None:
    """Return the condition without an answer for which a node failed, or None: neither it nor its opposite is known."""
    if node.status is not Status.FAILURE:
        return None
    if getattr(node, "unanswered", False):
        return node
    if isinstance(node, ResultNode) and not node.inverts:  # it is FAILURE whatever it asked
        return None
    return next(filter(None, map(_unanswered, node.children)), None)


@construct
@dataclass(slots=True)
class Invert(_Result):
    """FAILURE for SUCCESS and SUCCESS for FAILURE; FAILURE stays where a condition has no answer."""

    keyword: ClassVar[str] = "invert"
    becomes: ClassVar[dict[Status, Status]] = {Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.SUCCESS}


@construct
@dataclass(slots=True)
class ForceSuccess(_Result):
    """SUCCESS whatever the body ends with."""

    keyword: ClassVar[str] = "force_success"
    becomes: ClassVar[dict[Status, Status]] = {Status.SUCCESS: Status.SUCCESS, Status.FAILURE: Status.SUCCESS}


@construct
@dataclass(slots=True)
class ForceFailure(_Result):
    """FAILURE whatever the body ends with."""

    keyword: ClassVar[str] = "force_failure"
    becomes: ClassVar[dict[Status, Status]] = {Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.FAILURE}


@construct
@dataclass(slots=True)
class Fail(Part):
    """FAILURE with the given reason."""

    text: Text
    keyword: ClassVar[str] = "fail"

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read the reason."""
        if isinstance(value, Scalar) and value.text:
            return cls(mark, read_text(reader, value))
        reader.error(value.mark, "type-mismatch", "'fail' takes its reason as text", "write 'fail: why it failed'")
        return None

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return ref("text")

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {"reason": self.text.written}

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """It cannot succeed."""
        data.read(self.text.wires, known)
        return Flow(None, known)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the node."""
        return FailNode(path, self.text.bind(builder))


class FailNode(FlowNode):
    """Fails with its reason."""

    def __init__(self, path: str, text: Callable[[], str]) -> None:
        super().__init__(path)
        self.text = text

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Fail."""
        yield from ()
        self.feedback_message = self.text()
        return Status.FAILURE
