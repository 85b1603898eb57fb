"""Conditions: `guard` holds on every tick while its child runs, `check` is asked once, `skip_if` before a start."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Map, Mark, Scalar, Seq, Value
from stretch_bt.tree.flow.base import Flow, FlowNode, Known, Part, Wire, both, construct
from stretch_bt.tree.flow.text import Text, read_text
from stretch_bt.tree.fragments import Schema, form, ref
from stretch_bt.tree.types import BOOL

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["Check", "Condition", "Guard", "GuardNode", "SkipIf"]


@construct
@dataclass(slots=True)
class Guard(Part):
    """FAILURE on the first tick that finds `that` false; everything that runs under it is interrupted first."""

    that: Wire
    do: Part
    keyword: ClassVar[str] = "guard"
    transparent: ClassVar[bool] = True

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read `{that, do}`."""
        fields = reader.fields(value, mark, "guard", required=("that", "do"))
        if fields is None:
            return None
        that = reader.expression(fields["that"], BOOL, "guard.that")
        do = reader.body(fields["do"])
        return cls(mark, that, do) if that and do else None

    @classmethod
    def around(cls, reader: Reader, part: Part, value: Value) -> Part:
        """Read the `guard` beside a body: an expression, `{that, name}`, or a list of them."""
        for item in reversed(value.items) if isinstance(value, Seq) else (value,):
            name, that = None, item
            if isinstance(item, Map):
                fields = reader.fields(item, item.mark, "guard", required=("that",), optional=("name",))
                if fields is None:
                    continue
                that = fields["that"]
                name = reader.name(fields.get("name"))
            wire = reader.expression(that, BOOL, "guard")
            if wire is not None:
                part = cls(item.mark, wire, part, name=name, beside=True)
        return part

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return form({"that": ref("condition"), "do": ref("body")}, {"name": ref("word_name")})

    @classmethod
    def schema_beside(cls) -> Schema:
        """Return the schema of its word beside a node."""
        return ref("conditions")

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {"that": self.that.text}

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """The condition is asked before anything inside has run."""
        data.read((self.that,), known)
        return Flow(self.do.flow(data, known).success, known)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the guard around its child; a mocked guard asks its mock."""
        condition = builder.condition(self.that, path)
        return GuardNode(path, builder.child(self, self.do, path), condition)


class GuardNode(FlowNode):
    """Asks before each tick of the child."""

    def __init__(self, path: str, child: py_trees.behaviour.Behaviour, condition: Condition) -> None:
        super().__init__(path, child)
        self.condition = condition

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Ask, then tick the child."""
        if not self.condition.holds():
            self.feedback_message = self.condition.explain()
            return Status.FAILURE
        yield from self.child.tick()
        return self.child.status


@dataclass(slots=True)
class Condition:
    """An expression with the text and the values that explain it."""

    text: str
    holds: Callable[[], bool]
    values: Callable[[], str]

    def explain(self) -> str:
        """Return why it does not hold, with the values that it saw."""
        seen = self.values()
        return f"'{self.text}' does not hold" + (f": {seen}" if seen else "")


@construct
@dataclass(slots=True)
class Check(Part):
    """SUCCESS when `that` holds now, else FAILURE, with the reason `else` where it is given."""

    that: Wire
    reason: Text | None = None
    keyword: ClassVar[str] = "check"

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read `{that, else}`, or the expression itself."""
        if isinstance(value, Scalar):
            value = Map(((Scalar("that", False, value.mark), value),), value.mark)
        fields = reader.fields(value, mark, "check", required=("that",), optional=("else",))
        if fields is None:
            return None
        that, otherwise = reader.expression(fields["that"], BOOL, "check.that"), fields.get("else")
        reason = read_text(reader, otherwise) if isinstance(otherwise, Scalar) else None
        if otherwise is not None and (reason is None or not reason.written):
            reader.error(
                otherwise.mark, "type-mismatch", "'else' takes its reason as text", "write 'else: why it fails'"
            )
        return cls(mark, that, reason) if that else None

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        named = {"name": ref("word_name"), "else": ref("text")}
        return {"anyOf": [ref("condition"), form({"that": ref("condition")}, named)]}

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {"that": self.that.text} | ({"else": self.reason.written} if self.reason else {})

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """It only reads."""
        data.read((self.that, *(self.reason.wires if self.reason else ())), known)
        return Flow(known, known)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the condition as a node."""
        reason = None if self.reason is None else self.reason.bind(builder)
        return CheckNode(path, builder.condition(self.that, path), reason)


class CheckNode(FlowNode):
    """Asks once."""

    def __init__(self, path: str, condition: Condition, reason: Callable[[], str] | None = None) -> None:
        super().__init__(path)
        self.condition = condition
        self.reason = reason

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Ask."""
        yield from ()
        if self.condition.holds():
            return Status.SUCCESS
        self.feedback_message = self.reason() if self.reason else self.condition.explain()
        return Status.FAILURE


@dataclass(slots=True)
class SkipIf(Part):
    """SUCCESS at once when `that` holds at the start; otherwise what `do` does."""

    that: Wire
    do: Part
    keyword: ClassVar[str] = "skip_if"
    transparent: ClassVar[bool] = True

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    @classmethod
    def around(cls, reader: Reader, part: Part, value: Value) -> Part:
        """Read the `skip_if` beside a body."""
        that = reader.expression(value, BOOL, "skip_if")
        return cls(value.mark, that, part, name=f"{part.label}:skip_if", beside=True) if that else part

    @classmethod
    def schema_beside(cls) -> Schema:
        """Return the schema of its word beside a node."""
        return ref("condition")

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {"that": self.that.text}

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """The body may be passed over."""
        data.read((self.that,), known)
        ends = self.do.flow(data, known)
        failure = both(ends.failure, known) if self.that.may_lack(data.absent) else ends.failure
        return Flow(both(known, ends.success), failure)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the node."""
        return SkipIfNode(path, builder.child(self, self.do, path), builder.thunk(self.that))


class SkipIfNode(FlowNode):
    """Asks once, before the child starts."""

    def __init__(self, path: str, child: py_trees.behaviour.Behaviour, that: Callable[[], bool]) -> None:
        super().__init__(path, child)
        self.that = that

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Ask at the start only."""
        if self.status is not Status.RUNNING and self.that():
            self.feedback_message = "skipped"
            return Status.SUCCESS
        yield from self.child.tick()
        return self.child.status
