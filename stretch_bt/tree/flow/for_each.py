"""Once for each item of a list; none for an empty list."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.source import Mark, Value
from stretch_bt.tree.cell import Cell
from stretch_bt.tree.flow.base import Flow, FlowNode, Known, Part, Wire, both, construct, failed_pass
from stretch_bt.tree.flow.passes import FIELDS, Passes, PassKeys, passes_schema
from stretch_bt.tree.fragments import Schema, form, ref
from stretch_bt.tree.series import entries
from stretch_bt.tree.types import list_of

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["ForEach", "ForEachNode"]


@construct
@dataclass(slots=True)
class ForEach(Part):
    """Run `do` once for each of `items`, which it finds under the key `as`; ends at the first FAILURE."""

    items: Wire
    key: str
    key_mark: Mark
    do: Part
    passes: Passes
    keyword: ClassVar[str] = "for_each"
    transparent: ClassVar[bool] = True

    def children(self) -> Sequence[Part]:
        """Return the body."""
        return (self.do,)

    def is_long(self) -> bool:
        """Each pass begins in a tick of its own."""
        return True

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read `{items, as, do}`, and `index`, `collect` and `keys`."""
        fields = reader.fields(value, mark, "for_each", required=("items", "as", "do"), optional=("index", *FIELDS))
        if fields is None:
            return None
        key = reader.output(fields["as"], None, "for_each.as")
        do = reader.body(fields["do"])
        if key is None:
            return None
        item = reader.signature.declared(key)
        assert item is not None
        items = reader.value(fields["items"], list_of(item.type), "for_each.items")
        passes = Passes.read(reader, fields, do, key)
        return cls(mark, items, key, fields["as"].mark, do, passes) if items and do else None

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return form(
            {"items": ref("input_list"), "as": ref("key"), "do": ref("body")}, {"index": ref("key"), **passes_schema()}
        )

    def written(self) -> dict[str, str]:
        """Return its settings."""
        return {"items": self.items.text, "as": f"${self.key}"} | self.passes.written()

    def own_writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield the key of the items, and the keys of its passes."""
        for key, mark in ((self.key, self.key_mark), *self.passes.marks.items()):
            yield key, self.keyword, mark

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """The list may be empty, unless it is known at load."""
        data.read((self.items,), known)
        known = self.passes.begun(data, known)
        index = {self.passes.index} if self.passes.index else set()
        ends = self.do.flow(data, known | {self.key} | index)
        certain = self.items.is_constant and len(self.items.value) > 0
        return Flow(ends.success if certain else both(known, ends.success), both(ends.failure, known))

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the loop."""
        child, passes = builder.child(self, self.do, path), self.passes.bind(builder, path)
        return ForEachNode(path, child, builder.thunk(self.items), builder.cell(self.key), passes)


class ForEachNode(FlowNode):
    """One item starts per tick."""

    def __init__(
        self,
        path: str,
        child: py_trees.behaviour.Behaviour,
        items: Callable[[], Sequence[Any]],
        key: Cell,
        passes: PassKeys,
    ) -> None:
        super().__init__(path, child)
        self.items = items
        self.key = key
        self.keys = passes
        self.count = 0
        self.remaining: list[Any] = []

    def begin(self) -> None:
        """Take the list as it is now."""
        self.remaining = entries(self.items())
        self.count = len(self.remaining)
        self.keys.begin()

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Run the body for the next item."""
        if not self.remaining:
            return Status.SUCCESS
        if self.child.status is not Status.RUNNING:
            self.keys.start(self.count - len(self.remaining))
            self.key.write(self.remaining[0], self.path)
        yield from self.child.tick()
        if self.child.status is Status.SUCCESS:
            self.remaining.pop(0)
            self.keys.end()
            return Status.RUNNING if self.remaining else Status.SUCCESS
        if self.child.status is Status.FAILURE:
            self.feedback_message = failed_pass(self.count - len(self.remaining), self.child)
        return self.child.status
