"""What feeds the ports of a node or construct: its fields, inputs and outputs, each at its place."""

from __future__ import annotations

import re
from collections.abc import Iterable

from stretch_bt.source import Map, Mark, Scalar, Value, closest, is_nothing, is_null, stands_already, unknown_key
from stretch_bt.tree.document import Declared
from stretch_bt.tree.flow import Wire
from stretch_bt.tree.port import Port
from stretch_bt.tree.registry import RESERVED
from stretch_bt.tree.types import NONE, Type
from stretch_bt.tree.value_wiring import ValueWiring
from stretch_bt.tree.values import (
    braces,
    example,
)

__all__ = ["Wiring"]


class Wiring(ValueWiring):
    """Reads the mappings that give values to ports; mistakes are noted and reading goes on."""

    def fields(
        self,
        value: Value,
        mark: Mark,
        what: str,
        required: tuple[str, ...] = (),
        optional: tuple[str, ...] = (),
        bound: tuple[str, int] | None = None,
    ) -> dict[str, Value] | None:
        """Return the fields of a construct, or None when one is missing; `bound` is the field that ends a loop."""
        if bound is not None:
            required = (*required, bound[0])
        if not isinstance(value, Map):
            form = ", ".join(f"{name}: ..." for name in required)
            self.error(value.mark, "type-mismatch", f"{what!r} takes a mapping", f"write '{what}: {{{form}}}'")
            return None
        meant = self.unknown(value, what, (*required, *optional), required)
        missing = [name for name in required if name not in value]
        for name in missing:
            if bound is not None and name == bound[0] and name not in meant:
                hint = f"add '{name}: {bound[1]}', or another whole number"
                self.error(mark, "unbounded-loop", f"{what!r} has no bound", hint)
            elif name not in meant:
                self.error(mark, "port-missing", f"{what!r} needs {name!r}", f"add '{name}: ...'")
        return None if missing else {k.text: v for k, v in value}

    def unknown(self, value: Map, what: str, known: Iterable[str], required: Iterable[str]) -> set[str]:
        """Note every key that is not known, and return what the author seems to have meant by them."""
        known = dict.fromkeys(known)
        free = [name for name in known if name not in value]
        absent = {name for name in required if name not in value}
        meant: set[str] = set()
        for key, given in value:
            if key.text in known:
                continue
            guess = closest(key.text, free)
            given_already = closest(key.text, known)
            if guess not in absent and given_already is not None and given_already in value:
                self.error(key.mark, "port-unknown", f"{what!r} has no {key.text!r}", stands_already(given_already))
                continue
            word = None if guess else closest(key.text, RESERVED)
            if guess is None and word is None and len(absent) == 1:
                guess = next(iter(absent))
            hint = f"did you mean {guess!r}?" if guess else unknown_key(key, given, known)
            hint = f"did you mean {word!r}? {word!r} stands beside the node" if word else hint
            self.error(key.mark, "port-unknown", f"{what!r} has no {key.text!r}", hint or f"{what!r} has no ports")
            meant |= {guess} if guess else set()
            absent.discard(guess or "")
        return meant

    def full(self, key: Scalar, value: Value) -> Value | None:
        """Return the value given to a port: `$name` of the port itself where nothing is written; None, with an error, for null."""
        if is_null(value):
            self.error(
                value.mark,
                "value-missing",
                f"{key.text!r} is given null",
                "write 'none', or nothing for a key of that name",
            )
            return None
        return Scalar(f"${key.text}", False, key.mark) if is_nothing(value) else value

    def input(
        self, wires: dict[str, Wire], key: Scalar, value: Value, type_: Type, what: str, bounds: Port | Declared
    ) -> None:
        """Wire an input port."""
        if value.mark is key.mark and not self.is_name(key.text):
            guess = closest(key.text, [*self.signature.names, *self.document.params])
            hint = f"did you mean '${guess}'?" if guess else example(type_)
            message = f"{what} has no value, and nothing that is written here is called {key.text!r}"
            self.error(key.mark, "value-missing", message, hint)
            return
        none = bounds.check({}).optional if isinstance(bounds, Port) else bounds.has_default and bounds.default is None
        wire = self.value(value, type_, what, low=bounds.min, high=bounds.max, takes_none=none)
        if wire is not None:
            wires[key.text] = wire

    def sink(
        self,
        sinks: dict[str, tuple[str, Mark]],
        key: Scalar,
        value: Value,
        type_: Type,
        what: str,
        kind: str = "output",
    ) -> None:
        """Wire an output port, or an inout; a key that two outputs of one node write keeps only one of them."""
        name = self.output(value, type_, what, kind)
        if name is None:
            return
        other = next((port for port, (used, _) in sinks.items() if used == name), None)
        if other is not None:
            message = f"${name} takes both {other!r} and {key.text!r} of this node"
            self.error(value.mark, "key-duplicate", message, "use two keys")
        sinks[key.text] = (name, value.mark)

    def output(self, value: Value, type_: Type | None, what: str, kind: str = "output") -> str | None:
        """Return the key that an output, or an inout, writes."""
        text = value.text if isinstance(value, Scalar) else ""
        name = text.removeprefix("$")
        if not text.isascii() and text[:1] == "$":
            self.error(value.mark, "name", f"{text!r} cannot be a key", "use letters a to z, digits and _")
            return None
        if not re.fullmatch(r"\$[A-Za-z_]\w*", text, re.ASCII):
            message = f"{what} is an {kind}, so it takes a $key, not {text or 'this'!r}"
            self.error(value.mark, "output-literal", message, braces(value) or self.as_key(name, type_))
            # with its dollar it is that key, so that what reads the key is right
            return name if name in self.signature.keys or name in self.signature.outs else None
        declared = self.signature.declared(name)
        if declared is None:  # its name is no key's
            self.error(value.mark, "name", f"{text!r} cannot be a key", "use letters a to z, digits and _")
            return None
        if name in self.signature.ins:
            message = f"${name} is an input of tree {self.signature.name!r} and cannot be written"
            self.error(value.mark, "input-written", message, "use another key")
            return None
        if type_ is not None and type_ is not NONE and not declared.type.accepts(type_):
            message = f"${name} is {self.of(declared)} but {what} gives {type_}"
            self.error(value.mark, "type-mismatch", message, f"use a key of type {type_}")
            return None
        return name

    def as_key(self, name: str, type_: Type | None) -> str:
        """Return how an output names the key that was written without its dollar."""
        return f"write '${name}'" if name.isidentifier() and name.isascii() else "write '$key', with a name of your own"
