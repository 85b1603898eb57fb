"""What a loop keeps of its passes: their number, keys of its own, and lists of what each pass wrote."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stretch_bt.source import Map, Mark, Scalar, Value
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.flow.base import Flow, Known, Part, both
from stretch_bt.tree.fragments import Schema, ref
from stretch_bt.tree.series import EstimateList, errors_of
from stretch_bt.tree.values import written, written_pairs

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["FIELDS", "PassKeys", "Passes", "passes_schema"]

FIELDS = ("collect", "keys")


@dataclass(slots=True)
class Passes:
    """The keys that a loop itself writes: `index`, the lists of `collect` by the key that fills each, and its own `keys`."""

    index: str | None = None
    collect: dict[str, str] = field(default_factory=dict)  # list -> key whose values it takes
    own: dict[str, str] = field(default_factory=dict)  # key -> its declaration, as written
    fresh: Known = frozenset()  # of its own keys those without a default: unset as it begins
    marks: dict[str, Mark] = field(default_factory=dict)  # of what it writes
    refused: set[str] = field(default_factory=set)  # lists that are written wrongly, or meant, which was noted
    doubted: set[str] = field(default_factory=set)  # keys that a pass writes, one of which may have been meant

    @classmethod
    def read(cls, reader: Reader, fields: Mapping[str, Value], do: Part | None, item: str | None = None) -> Passes:
        """Read the fields of a loop that are about its passes; `item` is the key that the loop itself writes."""
        found = cls()
        if (index := fields.get("index")) is not None and (name := reader.output(index, None, "index")) is not None:
            found.index = name
            found.marks[name] = index.mark
        keys = fields.get("keys")
        found.own = {key.text: written(value) for key, value in keys} if isinstance(keys, Map) else {}
        found.fresh = frozenset(n for n in found.own if (d := reader.signature.keys.get(n)) and not d.has_default)
        if (collect := fields.get("collect")) is not None:
            found._read_collect(reader, collect, do, item)
        return found

    def _read_collect(self, reader: Reader, collect: Value, do: Part | None, item: str | None) -> None:
        if not isinstance(collect, Map) or not collect.pairs:
            reader.error(
                collect.mark, "type-mismatch", "'collect' takes lists by name", "write 'collect: {forces: $force}'"
            )
            return
        wrote = {key for key, _, _ in do.writes()} if do is not None else set()
        wrote |= {item} if item is not None else set()
        for key, value in collect:
            target = reader.output(Scalar("$" + key.text.removeprefix("$"), False, key.mark), None, "collect")
            source = value.text.removeprefix("$") if isinstance(value, Scalar) else ""
            if target is None or do is None:
                continue
            self.marks[target] = key.mark
            if source in wrote:
                self.collect[target] = source
            else:
                self.refused.add(target)
                self.doubted |= wrote
                if target in wrote and source.isidentifier():  # the two were swapped
                    self.refused.add(source)
                    self.marks.setdefault(source, key.mark)
                message = f"no pass of this loop writes {source or 'this'!r}"
                reader.error(value.mark, "collect", message, _meant(target, source, wrote))

    def begun(self, data: DataFlow, known: Known) -> Known:
        """Return the keys that are written once the loop has begun; the keys that it collects count as read."""
        data.names |= set(self.collect.values()) | self.refused | self.doubted
        return (known - self.fresh) | self.lists

    def ends(self, data: DataFlow, ends: Flow, known: Known, *keys: str) -> Flow:
        """Return how a loop ends: it fails, too, where a key with bounds that itself or one of its passes writes is to leave them."""
        bounded = data.bounded((*self.marks, *keys))
        return Flow(ends.success, both(ends.failure, known)) if bounded else ends

    @property
    def lists(self) -> Known:
        """The lists that it fills, which are there, empty, once the loop has begun."""
        return frozenset(self.collect) | self.refused

    def written(self) -> dict[str, str]:
        """Return its settings."""
        found = {"index": f"${self.index}"} if self.index else {}
        lists = {name: f"${key}" for name, key in self.collect.items()}
        found |= {"collect": written_pairs(lists)} if lists else {}
        return found | ({"keys": written_pairs(self.own)} if self.own else {})

    def bind(self, builder: Builder, path: str) -> PassKeys:
        """Return what does it in a run."""
        pairs = [(builder.cell(target), builder.cell(source)) for target, source in self.collect.items()]
        own = [(builder.cell(name), builder.default(name)) for name in self.own]
        return PassKeys(path, builder.cell(self.index) if self.index else None, pairs, own)


def _meant(target: str, source: str, wrote: set[str]) -> str:
    """Return what to write in place of a key that no pass writes."""
    of = source.removesuffix("_sd")
    if of != source and of in wrote:
        return f"collect ${of}: its list has the errors, and its mean and median take them"
    if target in wrote:
        return f"the list stands first: '{source or 'list'}: ${target}'"
    if not wrote:
        return "write a key in 'do'"
    return f"write one of {', '.join(f'${name}' for name in sorted(wrote)[:5])}"


class PassKeys:
    """Writes the keys of a loop as its passes begin and end."""

    def __init__(
        self, path: str, index: Cell | None, pairs: list[tuple[Cell, Cell]], own: list[tuple[Cell, Any]]
    ) -> None:
        self.path, self.index, self.pairs, self.own = path, index, pairs, own
        self.begun = 0  # passes, of all that the loop ever started
        self.before: list[int] = []  # how often each collected key had been written as the pass began

    def begin(self) -> None:
        """Start the loop: its own keys are fresh, its lists empty."""
        for cell, default in self.own:
            cell.reset(default)
        for target, _ in self.pairs:
            target.write(EstimateList(), self.path)

    def start(self, number: int) -> None:
        """Start a pass, counted from 0."""
        self.begun += 1
        if self.index is not None:
            self.index.write(number, self.path)
        self.before = [source.writes for _, source in self.pairs]

    def end(self) -> None:
        """Take what a pass wrote, if it wrote all that is collected."""
        for (_, source), before in zip(self.pairs, self.before, strict=True):
            if source.writes == before or source.value is MISSING:
                return
        for target, source in self.pairs:
            held = [] if target.value is MISSING else target.value
            target.write(EstimateList([*held, source.value], [*errors_of(held), source.error()]), self.path)


def passes_schema() -> dict[str, Schema]:
    """Return the schemas of the fields that all loops take."""
    lists: Schema = {"type": "object", "minProperties": 1, "additionalProperties": ref("key")}
    return {
        "collect": {**lists, "description": "lists, by name, of what each pass wrote to a key"},
        "keys": {
            "type": "object",
            "additionalProperties": ref("declaration"),
            "description": "its own keys, fresh each time it begins",
        },
    }
