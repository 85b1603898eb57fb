"""What every construct of the language has: how it is read, what it reads and writes, and how it is built.

One construct to a file: a `Part` that knows its keyword, its form in YAML, its data flow and its py_trees node.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Container, Generator, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar

import py_trees
from py_trees.common import Status

from stretch_bt.errors import NoAnswer
from stretch_bt.source import Mark
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.expression import Expression
from stretch_bt.tree.fragments import Schema

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow

__all__ = ["CONSTRUCTS", "Flow", "FlowNode", "Known", "Part", "Wire", "both", "construct", "failed_at", "why_failed"]

Known = frozenset[str]


class Flow(NamedTuple):
    """Keys that surely hold a value when a part ended well, and when it failed; None when it cannot end so."""

    success: Known | None
    failure: Known | None


def both(a: Known | None, b: Known | None) -> Known | None:
    """Return what is known when either of two ends may have been reached."""
    if a is None or b is None:
        return b if a is None else a
    return a & b


@dataclass(slots=True)
class Wire:
    """What feeds an input: a constant, or an expression with the keys that it reads."""

    mark: Mark
    expression: Expression | None = None
    value: Any = MISSING
    reads: tuple[tuple[str, Mark], ...] = ()
    readings: tuple[str, ...] = ()  # readings of devices that it uses
    text: str = ""
    may_be_absent: bool = False  # of an input that its caller may leave out: the port keeps its default
    optional: bool = False  # of a record that was left out: unset while nothing has written it
    #: the expression whose error the value has: a name as it is, or a function that passes an error on; else None
    source: Expression | None = None
    items: tuple[Mark, ...] = ()  # the places of the items of a list that is written out

    @property
    def is_constant(self) -> bool:
        """Whether the value is known at load."""
        return self.value is not MISSING

    def may_lack(self, absent: Container[str]) -> bool:
        """Whether there may be no value, where the keys of these names may hold none."""
        from stretch_bt.tree.expression.lack import may_lack

        return bool(self.readings) or (self.expression is not None and may_lack(self.expression, absent))

    def single_key(self) -> str | None:
        """Return the key when the wire is just that key."""
        from stretch_bt.tree.expression.parse import Name

        expression = self.expression
        if (
            isinstance(expression, Name)
            and len(expression.parts) == 1
            and self.reads
            and self.reads[0][0] == expression.parts[0]
        ):
            return self.reads[0][0]
        return None


@dataclass(slots=True)
class Part(ABC):
    """One place of a tree, read and typed."""

    mark: Mark
    name: str | None = field(default=None, kw_only=True)
    #: written beside a node, so it adds no segment of its own to the path of that node
    beside: bool = field(default=False, kw_only=True)
    keyword: ClassVar[str] = ""
    #: whether children are called by the parent's path: `main/press`, not `main/sequence/press`
    transparent: ClassVar[bool] = False

    @property
    def label(self) -> str:
        """The last segment of its path."""
        return self.name or self.keyword

    @property
    def opens_path(self) -> bool:
        """Whether the paths of its children begin with its own."""
        return not (self.beside or (self.transparent and self.name is None))

    def children(self) -> Sequence[Part]:
        """Return the parts inside, in order."""
        return ()

    def written(self) -> dict[str, str]:
        """Return what the file gives it besides its children, by name and as written."""
        return {}

    @classmethod
    def schema(cls) -> Schema | None:
        """Return the JSON Schema of what follows its keyword; None when no keyword introduces it."""
        return None

    @classmethod
    def schema_beside(cls) -> Schema | None:
        """Return the JSON Schema of its reserved word beside a node; None when it has none."""
        return None

    @abstractmethod
    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Check the names that are read against the names known to be written, and return the names known afterwards."""

    @abstractmethod
    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return a fresh py_trees node."""

    def is_long(self) -> bool:
        """Whether it may take more than one tick."""
        return any(child.is_long() for child in self.children())

    def absent(self, known: Container[str]) -> set[str]:
        """Return the keys that it may leave without a value where it ends with SUCCESS, of those `known` to be so already."""
        return set()

    def own_writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield every key that it writes by itself, with who writes it and where."""
        yield from ()

    def writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield every key that it, or something inside it, writes, with who writes it and where."""
        for part in self.walk():
            yield from part.own_writes()

    def walk(self) -> Iterator[Part]:
        """Yield the part and everything inside it, in order, without entering the trees that it calls."""
        yield self
        for child in self.children():
            yield from child.walk()


C = TypeVar("C", bound=type[Part])
CONSTRUCTS: dict[str, type[Part]] = {}


def construct(cls: C) -> C:
    """Add a construct to the language; its `read` takes the reader, the key's place and the value."""
    CONSTRUCTS[cls.keyword] = cls
    return cls


class FlowNode(py_trees.behaviour.Behaviour):
    """A node with one child, of our own where py_trees' decorators measured wrong (clock, empty lists, lost attempts)."""

    #: whether its message says why it failed; else what it did not decide is told by its child
    explains: ClassVar[bool] = True

    def __init__(self, path: str, child: py_trees.behaviour.Behaviour | None = None) -> None:
        super().__init__(name=path.rpartition("/")[2])
        self.path = path
        self.ticking = False
        self.unanswered = False  # whether it failed because its own expression reads what has no answer
        if child is not None:
            self.children.append(child)
            child.parent = self

    @property
    def child(self) -> py_trees.behaviour.Behaviour:
        """The only child."""
        return self.children[0]

    def update(self) -> Status:
        """Not called: `tick` asks `decide`."""
        return self.status

    def begin(self) -> None:
        """Prepare for a fresh start; called on each tick that finds the node not RUNNING."""

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Tick the child as needed and return the node's own status."""
        yield from ()
        return Status.INVALID

    def tick(self) -> Generator[py_trees.behaviour.Behaviour, None, None]:
        """Tick once."""
        self.ticking = True  # stays set when an error leaves the node, so that the runner can name it
        self.unanswered = False
        try:
            if self.status is not Status.RUNNING:
                self.feedback_message = ""
                self.begin()
            status = yield from self.decide()
        except NoAnswer as refusal:  # of readings in its own expression: a child reports its own as FAILURE
            self.feedback_message = refusal.reason
            self.unanswered = True
            status = Status.FAILURE
        if status is not Status.RUNNING:
            self.end_children()
        self.status = status
        self.ticking = False
        yield self

    def end_children(self) -> None:
        """Interrupt a child that still runs."""
        for child in self.children:
            if child.status is Status.RUNNING:
                child.stop(Status.INVALID)

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with this status, the child first."""
        if new_status is Status.INVALID:
            for child in self.children:
                if child.status is not Status.INVALID:
                    child.stop(Status.INVALID)
        self.status = new_status

    def tip(self) -> py_trees.behaviour.Behaviour | None:
        """Return the deepest node that decided the status."""
        if self.children and self.children[0].status is not Status.INVALID:
            return self.children[0].tip()
        return self if self.status is not Status.INVALID else None


def failed_at(root: Any) -> Any:
    """Return the node that made the tree fail: the last failed one, as deep as failures go."""
    node = root
    while True:
        failed = [child for child in node.children if child.status is Status.FAILURE]
        if not failed or (node.feedback_message and getattr(node, "explains", True)):
            return node
        node = failed[-1]


def why_failed(node: Any) -> str:
    """Return the path and the reason of what made a node fail."""
    at = failed_at(node)
    return f"{at.path}: {at.feedback_message or 'failed'}"


def failed_pass(number: int, node: Any) -> str:
    """Return in which pass of a loop, counted from 0, a node failed, and why."""
    return f"pass {number + 1} failed at {why_failed(node)}"
