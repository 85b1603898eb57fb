"""Writing keys from expressions, all read before any is written."""

from __future__ import annotations

from collections.abc import Callable, Container, Generator, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import py_trees
from py_trees.common import Status

from stretch_bt.errors import InvalidInput
from stretch_bt.source import Map, Mark, Scalar, Value, is_nothing, is_null
from stretch_bt.tree.cell import Cell
from stretch_bt.tree.expression.parse import Name
from stretch_bt.tree.flow.base import Flow, FlowNode, Known, Part, Wire, construct
from stretch_bt.tree.fragments import Schema, ref
from stretch_bt.tree.values import braces
from stretch_bt.units import Estimate

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["SetKeys", "SetKeysNode"]


@construct
@dataclass(slots=True)
class SetKeys(Part):
    """Give keys new values: `set: {presses: presses + 1}`; beside `x`, `x_sd` is its standard deviation."""

    wires: dict[str, Wire] = field(default_factory=dict)
    sds: dict[str, Wire] = field(default_factory=dict)
    marks: dict[str, Mark] = field(default_factory=dict)
    keyword: ClassVar[str] = "set"

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read a mapping from keys to values or expressions."""
        if not isinstance(value, Map) or not value.pairs:
            reader.error(
                value.mark,
                "type-mismatch",
                "'set' takes a mapping from keys to values",
                "write 'set: {count: count + 1}'",
            )
            return None
        found = cls(mark)
        for key, given in value:
            if key.text.endswith(")") and is_nothing(given):
                continue  # the rest of what a comma has cut, which was noted
            if found._read_sd(reader, value, key, given):
                continue
            name = reader.output(Scalar("$" + key.text.removeprefix("$"), False, key.mark), None, "set")
            declared = reader.signature.declared(name) if name else None
            if name is None or declared is None:
                continue
            found.marks[name] = key.mark  # also where its value is wrong: the mistake noted there is enough
            if is_nothing(given):
                reader.error(
                    key.mark, "value-missing", f"'set' gives ${name} no value", f"write '{key.text}: ...', or 'none'"
                )
                continue
            if is_null(given):
                reader.error(
                    given.mark, "value-missing", f"'set' gives ${name} null", f"write '{key.text}: none', or a value"
                )
                continue
            if isinstance(given, Map):
                hint = braces(given) or "write a value, or an expression in quotes"
                reader.error(given.mark, "type-mismatch", f"'set' gives ${name} a value, not a mapping", hint)
                continue
            wire = reader.set_value(given, declared, key.text)
            if wire is not None:
                found.wires[name] = wire
        return found

    def _read_sd(self, reader: Reader, whole: Map, key: Scalar, given: Value) -> bool:
        """Read the standard deviation of a key that is set beside it; return whether this was one."""
        of = key.text.removesuffix("_sd")
        declared = reader.signature.declared(of)
        if of == key.text or of not in whole or declared is None or reader.signature.declared(key.text) is not None:
            return False
        wire = reader.value(given, declared.type, key.text, 0.0)
        if wire is not None:
            self.sds[of] = wire
        return True

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return {"type": "object", "minProperties": 1, "additionalProperties": ref("value")}

    def written(self) -> dict[str, str]:
        """Return the new values by key."""
        return {key: wire.text for key, wire in self.wires.items()} | {
            f"{key}_sd": w.text for key, w in self.sds.items()
        }

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Everything is read before anything is written."""
        for key, wire in (*self.wires.items(), *self.sds.items()):
            data.read([wire], known, beside=self.wires.keys() - {key})
        # a name as it is may be absent, and so is the key that takes it; nothing can be worked out from it
        worked_out = [w for w in self.wires.values() if w.readings or not isinstance(w.expression, Name)]
        fails = any(wire.may_lack(data.absent) for wire in (*worked_out, *self.sds.values()))
        fails = fails or data.bounded(key for key, wire in self.wires.items() if not wire.is_constant)
        fails = fails or data.bounded(name for wire in self.wires.values() for name, _ in wire.reads)
        return Flow(known | set(self.marks), known if fails else None)

    def own_writes(self) -> Iterator[tuple[str, str, Mark]]:
        """Yield its keys."""
        yield from ((key, self.keyword, mark) for key, mark in self.marks.items())

    def absent(self, known: Container[str]) -> set[str]:
        """Return the keys that it may leave without a value."""
        copied = {key for key, wire in self.wires.items() if isinstance(wire.expression, Name) and wire.may_lack(known)}
        return copied | {key for key, wire in self.wires.items() if wire.value is None}

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return the node."""
        rows, copies = [], {}
        for key, wire in self.wires.items():
            sd = builder.thunk(self.sds[key]) if key in self.sds else builder.error_of(wire)
            rows.append((builder.cell(key), builder.thunk_or_none(wire), sd))
            if (source := builder.key_of(wire)) is not None:
                copies[builder.cell(key).name] = Copy(*source)
        return SetKeysNode(path, rows, copies)


@dataclass(frozen=True, slots=True)
class Copy:
    """Where a `set` takes a value from, if it takes it as it is: a key, or an attribute of its value."""

    cell: Cell
    attributes: tuple[str, ...]

    def follow(self, value: Any) -> Any:
        """Return the attribute of a value; None where it has none."""
        for part in self.attributes:
            value = getattr(value, part, None)
        return value


class SetKeysNode(FlowNode):
    """Writes the keys in one tick; `copies` are the keys, by name, that copy another key or its attribute."""

    def __init__(
        self,
        path: str,
        rows: list[tuple[Cell, Callable[[], Any], Callable[[], float | None] | None]],
        copies: Mapping[str, Copy] | None = None,
    ) -> None:
        super().__init__(path)
        self.rows = rows
        self.copies = copies or {}

    def decide(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Read all, then write all."""
        yield from ()
        read = [(cell, _estimate(cell, value(), sd() if sd is not None else None)) for cell, value, sd in self.rows]
        for cell, value in read:
            if value is None:
                cell.unset(self.path)
            else:
                cell.write(value, self.path)
        return Status.SUCCESS


def _estimate(cell: Cell, value: Any, sd: float | None) -> Any:
    """Return a value with its standard deviation, where it has one."""
    if sd is None or value is None:
        return value
    if sd < 0:
        raise InvalidInput(f"the standard deviation of ${cell.name.rpartition('/')[2]} is {sd:g}; it is not below 0")
    return Estimate(value, sd)
