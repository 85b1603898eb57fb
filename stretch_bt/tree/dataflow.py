"""Whether every key is written before it is read, on every way through a tree."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from functools import cached_property

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Mark, closest
from stretch_bt.tree.document import Signature
from stretch_bt.tree.flow.base import Known, Part, Wire
from stretch_bt.tree.flow.call import Call
from stretch_bt.tree.flow.leaf import Leaf
from stretch_bt.tree.types import ANY, Family
from stretch_bt.tree.values import sample

__all__ = ["DataFlow", "check_flow"]


class DataFlow:
    """Collects reads that nothing surely wrote before; a place is reported once."""

    def __init__(self, signature: Signature, body: Part, writers: dict[str, list[tuple[str, Mark]]]) -> None:
        self.signature = signature
        self.body = body
        self.writers = writers
        self.diagnostics: list[Diagnostic] = []
        self.names: set[str] = set()  # that something reads
        self._seen: set[tuple[str, Mark]] = set()

    @cached_property
    def absent(self) -> set[str]:
        """The keys that may hold nothing though they were written: by their default, by `none`, or as a node or caller had nothing."""
        own = (*self.signature.keys.values(), *self.signature.outs.values())
        found = {d.name for d in own if d.has_default and d.default is None}
        found |= {*self.signature.ins, *self.signature.inouts}
        parts, before = list(self.body.walk()), -1
        while len(found) > before:  # a `set` hands absence on
            before = len(found)
            found = found.union(*(part.absent(found) for part in parts))
        return found

    def bounded(self, names: Iterable[str]) -> bool:
        """Whether one of these names has bounds, outside of which nothing is read or written."""
        declared = (self.signature.declared(name) for name in names)
        return any(d is not None and d.bounded for d in declared)

    def read(self, wires: Iterable[Wire], known: Known, beside: Container[str] = ()) -> None:
        """Note each key that these wires read and that is not surely written; a record that was left out may be unset.

        `beside` are the keys that the same place writes once all is read.
        """
        for wire in wires:
            self.names |= {name for name, _ in wire.reads}
            for name, mark in wire.reads:
                if not wire.optional and name not in known and (name, mark) not in self._seen:
                    self._seen.add((name, mark))
                    if self._is_meant_param(name):
                        continue
                    self.diagnostics.append(self._beside(name, mark) if name in beside else self._unset(name, mark))

    def _is_meant_param(self, name: str) -> bool:
        """Whether a key has the name of a param, which was told where it is written: a read of it is right once that is mended."""
        declared = self.signature.declared(name)
        return declared is not None and declared.inferred and name in self.signature.document.params

    def read_over(self, inouts: Mapping[str, tuple[str, Mark]], optional: Container[str], known: Known) -> None:
        """Note each key that is read and written over, as one that is read; an optional one may be unset."""
        for name, (key, mark) in inouts.items():
            self.read((Wire(mark, reads=((key, mark),), optional=name in optional),), known)

    @staticmethod
    def _beside(name: str, mark: Mark) -> Diagnostic:
        message = f"${name} may be unset here: one 'set' reads all that it reads before it writes"
        return mark.error("read-before-write", message, f"write another 'set' after the one that writes ${name}")

    def _unset(self, name: str, mark: Mark) -> Diagnostic:
        writers = [(who, m) for who, m in self.writers.get(name, []) if m != mark]
        if not writers:
            hint = self.given_by(name, mark) or f"write it first{self._or_default(name)}"
            return mark.error("read-before-write", f"${name} is never written", hint)
        places = ", ".join(f"{who!r} (line {m.line})" for who, m in writers[:3])
        later = all((m.line, m.column) > (mark.line, mark.column) for _, m in writers)
        why = "which comes after this read" if later else "which may fail or be passed over before this read"
        hint = "write it before" if later else "write it on every way to this place"
        message = f"${name} may be unset here: it is written only in {places}, {why}"
        return mark.error("read-before-write", message, f"{hint}{self._or_default(name)}")

    def given_by(self, name: str, before: Mark | None = None) -> str:
        """Return how to have a name from a place, before another, that has an output of it and leaves it out, or nothing."""
        for part in self.body.walk():
            late = before is not None and (part.mark.line, part.mark.column) >= (before.line, before.column)
            if late or not isinstance(part, Leaf | Call):
                continue
            known = part.info.outputs if isinstance(part, Leaf) else part.target.outs
            if name in known and name not in part.outputs:
                return (
                    f"{part.label!r} (line {part.mark.line}) gives it where it is named among its ports: '{{{name}}}'"
                )
        return ""

    def _or_default(self, name: str) -> str:
        declared = self.signature.declared(name)
        if declared is None or declared.type.family in (Family.OBJECT, Family.ANY):
            return ""
        value = "[]" if declared.type.item else sample(declared.type)
        return f", or give it a default under 'keys': '{name}: {{type: {declared.type}, default: {value}}}'"


def check_flow(
    signature: Signature,
    body: Part,
    extras: Iterable[Part],
    writers: dict[str, list[tuple[str, Mark]]],
    *,
    understood: bool = True,
) -> list[Diagnostic]:
    """Check one tree; `extras` (its `finally`) may run when nothing of the body has. What is not `understood` may read any key."""
    data = DataFlow(signature, body, writers)
    start = (
        frozenset(signature.ins)
        | {d.name for d in signature.inouts.values() if not d.may_be_absent}
        | {d.name for table in (signature.keys, signature.outs) for d in table.values() if d.has_default}
    )
    done = body.flow(data, start)
    for part in extras:
        part.flow(data, start)
    for out in signature.outs.values():
        if out.scene:
            data.diagnostics += [
                mark.error(
                    "output-of-scene", f"${out.name} is written here, and the scene alone knows it", "write another key"
                )
                for _, mark in writers.get(out.name, [])
            ]
        elif out.name not in writers and not out.has_default:
            hint = data.given_by(out.name) or f"write ${out.name} in the body"
            data.diagnostics.append(out.mark.error("output-unwritten", f"output {out.name!r} is never written", hint))
        elif done.success is not None and out.name not in done.success:
            data.diagnostics.append(
                out.mark.error(
                    "output-unwritten",
                    f"output {out.name!r} may be unset when {signature.name!r} succeeds",
                    "write it on every way that succeeds, or give it a default",
                )
            )
    if understood and not data.diagnostics:
        data.diagnostics += _unread(signature, writers, data.names)
    return data.diagnostics


def _unread(signature: Signature, writers: dict[str, list[tuple[str, Mark]]], read: set[str]) -> list[Diagnostic]:
    """Warn of each key that the tree names and writes and that nothing reads: it may be another one, misspelt."""
    used = read | set(signature.outs) | set(signature.inouts) | signature.left_out
    found = []
    for name, places in writers.items():
        declared = signature.declared(name)
        if declared is not None and declared.type is ANY:  # of one that is `none` alone, reads are not known
            continue
        if name not in used:
            hint = _meant(name, used) or "read it, make it an 'out', or leave it out"
            found.append(places[0][1].warning("key-unread", f"${name} is written and never read", hint))
    for declared in signature.keys.values():
        if not (declared.inferred or declared.name in read or declared.name in writers):
            hint = _meant(declared.name, {*signature.names} - {declared.name}) or "remove it, or read it"
            found.append(declared.mark.warning("key-unread", f"${declared.name} is declared and never read", hint))
    return found


def _meant(name: str, known: Iterable[str]) -> str:
    """Return a hint with the name that a name resembles, or nothing."""
    guess = closest(name, known)
    return f"did you mean '{guess}'? If not, leave it out" if guess else ""
