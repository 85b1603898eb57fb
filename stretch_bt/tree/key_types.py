"""The types of keys from what writes them: worked out from each other until nothing changes, since an expression may read other keys."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Mark, Scalar, Value
from stretch_bt.tree.declarations import wrong_unit
from stretch_bt.tree.document import Declared, Signature
from stretch_bt.tree.expression import ExpressionError, names, parse, typecheck
from stretch_bt.tree.expression.typecheck import Origin, Unresolved
from stretch_bt.tree.scope import TreeScope
from stretch_bt.tree.types import ANY, NONE, UNKNOWN, Type, joined, list_of
from stretch_bt.tree.values import is_none, literal_type, reads_as_expression

__all__ = ["KeyTypes", "KeyWriter"]

_ROUNDS = 50  # a chain of keys, each set from the one before, is as long as that


@dataclass(slots=True)
class KeyWriter:
    """A place that writes a key: of a type, or of the type of a value; `item` takes its items, `each` makes a list of it, `over` reads it before."""

    key: str
    mark: Mark
    type: Type | None = None
    value: Value | None = None
    item: bool = False
    each: bool = False
    over: bool = False


class KeyTypes:
    """Gives each key of a tree without a type the type that all its writers share.

    Parameters
    ----------
    writers
        Writers of all keys of the tree.
    known
        Names of keys whose type is declared.
    """

    def __init__(self, signature: Signature, writers: list[KeyWriter], known: set[str]) -> None:
        self.signature = signature
        self.scope = TreeScope(signature)
        self.writers = writers
        self.open = [w for w in writers if w.key not in known and w.key not in signature.ins]

    def settle(self, every: list[Declared]) -> Iterator[Diagnostic]:
        """Give each of some keys and inputs its type; yield what is wrong with them."""
        self.take_all()
        for declared in every:
            if declared.type is UNKNOWN and self.is_never_there(declared):
                declared.type = NONE
        self.take_all()  # of what is given those
        for declared in every:
            if declared.type is UNKNOWN:
                declared.type = ANY
                yield from self.untyped(declared)
            if (wrong := wrong_unit(declared)) is not None:
                yield wrong

    def take_all(self) -> None:
        """Widen the types of keys until nothing changes."""
        for _ in range(_ROUNDS):
            changed = [self.take(writer) for writer in self.open]
            if not any(changed):
                return

    def take(self, writer: KeyWriter) -> bool:
        """Widen the type of a key by one of its writers; return whether that changed it."""
        declared = self.signature.declared(writer.key)
        type_ = self.type_of(writer)
        if declared is None or type_ is None or type_ is ANY:
            return False
        if NONE in (declared.type, type_):  # a value that is never there takes the type of the other one
            wider: Type | None = declared.type if type_ is NONE and declared.type is not UNKNOWN else type_
        else:
            wider = joined(declared.type, type_)
        if wider is None or wider == declared.type:
            return False
        declared.type = wider
        return True

    def type_of(self, writer: KeyWriter) -> Type | None:
        """Return the type that a writer gives, or None where it is not known yet, or never."""
        if writer.type is not None:
            return writer.type
        if writer.value is None or is_none(writer.value):
            return None
        found = self.type_of_value(writer.value)
        if found is None or found is UNKNOWN:
            return None
        if writer.item:
            return found.item
        return list_of(found) if writer.each else found

    def type_of_value(self, value: Value) -> Type | None:
        """Return the type of a literal or an expression, None where it is not known."""
        if not isinstance(value, Scalar):
            return literal_type(value, self.type_of_item)
        if not reads_as_expression(value):
            return literal_type(value)
        try:
            found = typecheck(parse(value.text), self.scope)
        except ExpressionError:
            return None
        return None if found is ANY else found

    def type_of_item(self, value: Scalar) -> Type | None:
        """Return the type of an item of a list that is the name of a param, None of any other: a bare word is text."""
        return self.type_of_value(value) if value.text.startswith("$") and reads_as_expression(value) else None

    def is_never_there(self, declared: Declared) -> bool:
        """Whether a key holds `none` alone: by its default, and by whatever writes it."""
        writers = [writer for writer in self.writers if writer.key == declared.name]
        nothing = all(w.value is not None and is_none(w.value) and not (w.item or w.each) for w in writers)
        return nothing and (bool(writers) or (declared.has_default and declared.default is None))

    def untyped(self, declared: Declared) -> Iterator[Diagnostic]:
        """Yield that a key is written from itself, or in a circle; where its values are wrong, that is noted at their places."""
        writers = [w for w in self.writers if w.key == declared.name and isinstance(w.value, Scalar) and not w.each]
        with suppress(ExpressionError, Unresolved):
            read = {n.parts[0] for w in writers for n in names(parse(w.value.text))}  # type: ignore[union-attr]
            known = [
                self.scope.resolve((name,)) for name in read if name not in ("task", *self.signature.document.devices)
            ]
            if known and all(symbol.type not in (ANY, UNKNOWN) for symbol in known):
                return  # its mistake is noted at its place
            written = {w.key for w in self.writers}
            without = [symbol for symbol in known if symbol.type in (ANY, UNKNOWN)]
            noted = any(symbol.origin is not Origin.KEY or symbol.name not in written for symbol in without)
            if writers and read and not noted:
                alone = "itself alone" if read == {declared.name} else f"{', '.join(sorted(read))} alone"
                message = f"the type of ${declared.name} follows from nothing: it is written from {alone}"
                form = f"{declared.name}: {{default: 0}}"
                form = f"keys: {{{form}}}" if declared.name in self.signature.keys else form
                yield writers[0].mark.error("type-missing", message, f"give it a default: '{form}'")
