"""The types of names that a tree does not declare: a key has that of what writes it, an input that of the ports it reaches.

Nodes and calls give their outputs a type at once. A `set`, a `for_each` and a `collect` give that of an expression, which may read
other such keys, so they are worked out until nothing changes.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Map, Mark, Scalar, Value, is_nothing, walk
from stretch_bt.tree import registry
from stretch_bt.tree.declarations import Declarations, wrong_unit
from stretch_bt.tree.document import Declared, Signature
from stretch_bt.tree.expression import FUNCTIONS, ExpressionError, names, parse, typecheck
from stretch_bt.tree.expression.typecheck import Origin, Unresolved
from stretch_bt.tree.places import Place, places
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.registry import NodeInfo
from stretch_bt.tree.scope import TreeScope
from stretch_bt.tree.types import ANY, INT, NONE, UNKNOWN, Type, joined, list_of
from stretch_bt.tree.values import is_none, literal_type, reads_as_expression

__all__ = ["is_construct", "settle_types"]

_KEY = re.compile(r"\$?([A-Za-z_]\w*)", re.ASCII)
_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
#: that mean something else in expressions
_WORDS = ("task", "none", "true", "false", "and", "or", "not")
_LOOPS = ("for_each", "repeat", "until")
_ROUNDS = 50  # a chain of keys, each set from the one before, is as long as that


def is_construct(word: str) -> bool:
    """Whether a word is a construct of the language."""
    from stretch_bt.tree.flow import CONSTRUCTS

    return word in CONSTRUCTS


@dataclass(frozen=True, slots=True)
class _Port:
    """A port of a node, or of a tree that is called, as far as its border goes."""

    type: Type
    min: float | None = None
    max: float | None = None
    needed: bool = True
    declared: Port | Declared | None = None


@dataclass(frozen=True, slots=True)
class _Ports:
    """What a place is given, what it gives, and which of these it reads and writes over."""

    inputs: dict[str, _Port]
    outputs: dict[str, Type]
    over: Container[str]


def _of_tree(tree: Signature) -> _Ports:
    borders = (*tree.ins.values(), *tree.inouts.values())
    given = {d.name: _Port(d.type, d.min, d.max, not d.has_default, d) for d in borders}
    return _Ports(given, {d.name: d.type for d in (*tree.outs.values(), *tree.inouts.values())}, tree.inouts)


def _of_node(info: NodeInfo) -> _Ports:
    given = {
        p.name: _Port(info.types[p.name], p.min, p.max, p.required, p)
        for p in (*info.of(Role.INPUT), *info.of(Role.INOUT))
    }
    return _Ports(given, info.outputs | info.inouts, info.inouts)


@dataclass(slots=True)
class _Writer:
    """A place that writes a key: of a type, or of that of a value; `item` takes the items of it, `each` makes a list of it."""

    key: str
    mark: Mark
    type: Type | None = None
    value: Value | None = None
    item: bool = False
    each: bool = False


def settle_types(signature: Signature) -> list[Diagnostic]:
    """Give every input, output and key of a tree its type, after those of the trees that it calls; once for each tree."""
    if signature.settled:
        return []
    signature.settled = True
    return _Keys(signature).settle()


class _Keys:
    def __init__(self, signature: Signature) -> None:
        self.signature = signature
        self.document = signature.document
        self.scope = TreeScope(signature)
        self.places = list(places(signature.body, is_construct))
        self.found: list[Diagnostic] = []
        self.clashes: set[str] = set()
        self.writers: list[_Writer] = []
        self.open: list[_Writer] = []  # of keys whose type follows from them
        self.nodes: dict[str, _Ports] = {}

    def settle(self) -> list[Diagnostic]:
        self.keys_of_loops()
        for place in self.places:
            target = self.document.tree(place.word.text)
            if target is not None:
                self.found += settle_types(target)
        self.inputs()
        self.lone_deviations()
        self.signature.read = self.names_read()
        self.writers = [*self.explicit(), *self.left_out()]
        self.keys(self.writers)
        every = [declared for name in self.signature.names if (declared := self.signature.declared(name)) is not None]
        for declared in every:
            if declared.type is UNKNOWN and self.is_never_there(declared):
                declared.type = NONE
        self.take_all()  # of what is given those
        for declared in every:
            if declared.type is UNKNOWN:
                declared.type = ANY
                self.note_untyped(declared)
            if (wrong := wrong_unit(declared)) is not None:
                self.found.append(wrong)
        return self.found

    def is_never_there(self, declared: Declared) -> bool:
        """Whether a key holds `none` alone: by its default, and by whatever writes it."""
        writers = [writer for writer in self.writers if writer.key == declared.name]
        nothing = all(w.value is not None and is_none(w.value) and not (w.item or w.each) for w in writers)
        return nothing and (bool(writers) or (declared.has_default and declared.default is None))

    def note_untyped(self, declared: Declared) -> None:
        """Note a key that is written from itself, or in a circle; where its values are wrong, that is noted at their places."""
        writers = [w for w in self.writers if w.key == declared.name and isinstance(w.value, Scalar) and not w.each]
        with suppress(ExpressionError, Unresolved):
            read = {n.parts[0] for w in writers for n in names(parse(w.value.text))}  # type: ignore[union-attr]
            known = [self.scope.resolve((name,)) for name in read if name not in ("task", *self.document.devices)]
            if known and all(symbol.type not in (ANY, UNKNOWN) for symbol in known):
                return  # what is wrong with it is noted at its place
            written = {w.key for w in self.writers}
            untyped = [symbol for symbol in known if symbol.type in (ANY, UNKNOWN)]
            noted = any(symbol.origin is not Origin.KEY or symbol.name not in written for symbol in untyped)
            if writers and read and not noted:
                alone = "itself alone" if read == {declared.name} else f"{', '.join(sorted(read))} alone"
                message = f"the type of ${declared.name} follows from nothing: it is written from {alone}"
                form = f"{declared.name}: {{default: 0}}"
                form = f"keys: {{{form}}}" if declared.name in self.signature.keys else form
                self.found.append(writers[0].mark.error("type-missing", message, f"give it a default: '{form}'"))

    def keys_of_loops(self) -> None:
        """Take the keys that loops declare for themselves among those of the tree."""
        declarations = Declarations(partial(registry.object_types, self.document.classes.values()), self.found)
        for place in self.places:
            own = place.given.get("keys") if place.word.text in _LOOPS else None
            for key, spec in own if isinstance(own, Map) else ():
                first = self.signature.declared(key.text)
                if first is not None:
                    message = f"${key.text} is declared twice (first on line {first.mark.line})"
                    self.found.append(key.mark.error("key-duplicate", message, "keep one"))
                else:
                    self.signature.keys[key.text] = declarations.read(key, spec, "key")

    # --- inputs

    def inputs(self) -> None:
        """Give each input without a type that of the ports which it reaches, and their bounds."""
        for declared in (*self.signature.ins.values(), *self.signature.inouts.values()):
            reached = [port for place in self.places for port in self.reached(place, declared.name)]
            if declared.type is UNKNOWN:
                self.take_type(declared, reached)
            declared.reaches = [port.declared for port in reached if port.declared is not None]
            for port in reached:
                declared.min = max((b for b in (declared.min, port.min) if b is not None), default=None)
                declared.max = min((b for b in (declared.max, port.max) if b is not None), default=None)
            if declared.listed and reached and not _needed(declared.name in self.signature.inouts, reached):
                declared.has_default = declared.may_be_absent = True

    def take_type(self, declared: Declared, reached: list[_Port]) -> None:
        types = [port.type for port in reached if port.type is not UNKNOWN]
        if not types and declared.name in self.signature.inouts:
            return  # what writes it tells
        if not types:
            message = f"no port tells the type of the input {declared.name!r}"
            hint = f"write '{declared.name}: {{type: Length}}', or give it a default"
            self.found.append(declared.mark.error("type-missing", message, hint))
            declared.type, declared.doubtful = ANY, True
            return
        other = next((t for t in types if joined(types[0], t) is None), None)
        if other is not None:
            message = f"the input {declared.name!r} reaches ports of two types, {types[0]} and {other}"
            self.found.append(declared.mark.error("type-mismatch", message, "use two inputs"))
            declared.type, declared.doubtful = ANY, True
            return
        # the narrower of two that meet: what it takes, both take
        declared.type = next((t for t in types if all(u.accepts(t) for u in types)), types[0])

    def reached(self, place: Place, name: str) -> Iterator[_Port]:
        """Yield each input port of a place that a name is wired to as it is."""
        for port, given in self.ports(place).inputs.items():
            value = place.given.get(port)
            if value is None:
                if port == name and given.type.is_record:
                    yield given
            elif (is_nothing(value) and port == name) or (isinstance(value, Scalar) and value.text == f"${name}"):
                yield given

    def ports(self, place: Place) -> _Ports:
        """Return what a place is given and gives; of nodes once each, since most stand at many places."""
        word = place.word.text
        target = self.document.tree(word)
        if target is not None:
            return _of_tree(target)
        if word not in self.nodes:
            info = self.document.node(word)
            self.nodes[word] = _Ports({}, {}, ()) if info is None else _of_node(info)
        return self.nodes[word]

    # --- keys

    def names_read(self) -> set[str]:
        """Return every name that something in the body may read: in an expression or text, or by a record that is left out."""
        found = set(self.signature.outs) | set(_words(self.signature.body))
        for place in self.places:
            for port, given in self.ports(place).inputs.items():
                if given.type.is_record and port not in place.given:
                    found.add(port)
        return found

    def explicit(self) -> Iterator[_Writer]:
        """Yield the writers of keys that the file names."""
        for place in self.places:
            word, given = place.word.text, place.given
            if word == "set":
                yield from self.of_set(given)
            elif word == "for_each" and isinstance(given.get("as"), Scalar):
                yield from _named(given.get("as"), items=given.get("items"))
                self.check_index(given)
            for port, type_ in self.ports(place).outputs.items():
                value = given.get(port)
                if value is not None and is_nothing(value):
                    yield _Writer(port, given.key(port).mark, type_)
                else:
                    yield from _named(value, type_)
            if is_construct(word):
                yield from _named(given.get("index"), INT)
                collect = given.get("collect")
                for key, value in collect if isinstance(collect, Map) else ():
                    yield _Writer(key.text.removeprefix("$"), key.mark, value=value, each=True)

    def check_index(self, given: Map) -> None:
        """Note an `index` that is the key of the items too."""
        item, index = given.get("as"), given.get("index")
        if isinstance(item, Scalar) and isinstance(index, Scalar) and item.text == index.text:
            self.found.append(
                index.mark.error("key-duplicate", f"{index.text} is the item of each pass already", "name another key")
            )

    def lone_deviations(self) -> None:
        """Note each `x_sd` that is set alone where another `set` gives it beside `x`, whose deviation it would take from it as a key."""
        tables = [place.given for place in self.places if place.word.text == "set"]
        written = [{key.text.removeprefix("$"): key.mark for key, _ in table} for table in tables]
        beside = {name: keys[name] for keys in written for name in keys if name.endswith("_sd") and name[:-3] in keys}
        for name, first in beside.items():
            for keys in written if self.signature.declared(name) is None else ():
                if name in keys and name[:-3] not in keys:
                    message = f"${name} is set alone, and beside ${name[:-3]} on line {first.line}, where it is the deviation of that"
                    hint = f"set both, as in 'set: {{{name[:-3]}: {name[:-3]}, {name}: ...}}'"
                    self.found.append(keys[name].error("key-duplicate", message, hint))

    def of_set(self, given: Map) -> Iterator[_Writer]:
        for key, value in given:
            name = key.text.removeprefix("$")
            of = name.removesuffix("_sd")
            beside = of != name and (of in given or f"${of}" in given)
            if not (beside and self.signature.declared(name) is None):
                yield _Writer(name, key.mark, value=value)

    def left_out(self) -> Iterator[_Writer]:
        """Yield the writers of records that the file leaves out, where the tree reads them."""
        first: dict[str, Place] = {}
        for place in self.places:
            ports = self.ports(place)
            for port, type_ in ports.outputs.items():
                if port in place.given or not type_.is_record:
                    continue
                if port in ports.over:
                    if self.is_free(port, type_):
                        self.signature.left_out.add(port)
                        yield _Writer(port, place.word.mark, type_)
                    continue
                if not self.takes(port, type_):
                    continue
                other = first.setdefault(port, place)
                if other.word.text != place.word.text:
                    message = (
                        f"both {other.word.text!r} (line {other.word.mark.line}) and {place.word.text!r} give {port!r}"
                    )
                    hint = f"name it where it is wanted: '{{{port}}}', and give the other one a key of its own"
                    self.found.append(place.word.mark.error("record-ambiguous", message, hint))
                self.signature.left_out.add(port)
                yield _Writer(port, place.word.mark, type_)

    def takes(self, name: str, type_: Type) -> bool:
        """Whether a record that is left out is written: something reads its name, and the name is no other thing."""
        return name in self.signature.read and self.is_free(name, type_)

    def is_free(self, name: str, type_: Type) -> bool:
        """Whether a record may be written to the key of its name: the name is no param, input or key of another type."""
        if name in self.document.params or name in self.signature.ins:
            return False
        declared = self.signature.declared(name)
        return declared is None or declared.type is UNKNOWN or declared.type.accepts(type_)

    def keys(self, writers: list[_Writer]) -> None:
        """Give each key the type that all its writers share."""
        given = {
            n
            for table in (self.signature.inouts, self.signature.outs, self.signature.keys)
            for n, d in table.items()
            if d.type is not UNKNOWN
        }
        for writer in writers:
            self.check_name(writer)
            if self.signature.declared(writer.key) is None and _KEY.fullmatch(writer.key):
                self.signature.keys[writer.key] = Declared(writer.key, UNKNOWN, writer.mark, inferred=True)
        self.open = [w for w in writers if w.key not in given and w.key not in self.signature.ins]
        self.take_all()

    def take_all(self) -> None:
        """Widen the types of keys until nothing changes."""
        for _ in range(_ROUNDS):
            changed = [self.take(writer) for writer in self.open]
            if not any(changed):
                return

    def check_name(self, writer: _Writer) -> None:
        """Note a key that has the name of something else; an input may have that of a param, which it then hides."""
        name, param = writer.key, self.document.params.get(writer.key)
        if name in self.signature.ins or name in self.clashes:
            return
        if param is not None:
            message = f"${name} has the name of a param (line {param.mark.line})"
        elif name in self.document.devices:
            message = f"${name} has the name of a device (line {self.document.devices[name].mark.line})"
        elif name in (*FUNCTIONS, *_WORDS):
            message = f"${name} has the name of something else in expressions"
        else:
            return
        self.clashes.add(name)
        self.found.append(writer.mark.error("key-duplicate", message, "rename one of them"))

    def take(self, writer: _Writer) -> bool:
        """Widen the type of a key by one of its writers; return whether that changed it."""
        declared = self.signature.declared(writer.key)
        type_ = self.type_of(writer)
        if declared is None or type_ is None or type_ is ANY:
            return False
        if NONE in (declared.type, type_):  # what is never there has the type of whatever else is
            wider: Type | None = declared.type if type_ is NONE and declared.type is not UNKNOWN else type_
        else:
            wider = joined(declared.type, type_)
        if wider is None or wider == declared.type:
            return False
        declared.type = wider
        return True

    def type_of(self, writer: _Writer) -> Type | None:
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


def _needed(written_over: bool, reached: list[_Port]) -> bool:
    """Whether a tree needs an input: one of its ports does, or the first one of what is written over after that."""
    return reached[0].needed if written_over else any(port.needed for port in reached)


def _named(key: Value | None, type_: Type | None = None, items: Value | None = None) -> Iterator[_Writer]:
    """Yield the writer of the key that a value names, of a type or of that of the items of a list."""
    match = _KEY.fullmatch(key.text) if isinstance(key, Scalar) else None
    if match is not None and isinstance(key, Scalar):
        yield _Writer(match[1], key.mark, type_, items, item=items is not None)


def _words(body: Value) -> Iterator[str]:
    """Yield the words of every value that is written in a body, and the keys that stand short."""
    for key, value in walk(body):
        if isinstance(value, Scalar):
            if key is not None and is_nothing(value):
                yield key.text
            else:
                yield from _NAME.findall(value.text)
