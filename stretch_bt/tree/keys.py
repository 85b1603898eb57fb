"""The types of names that a tree does not declare: a key has the type of its writers, an input the type of the ports it reaches.

Nodes and calls give their outputs a type at once; a `set`, a `for_each` and a `collect` give the type of an expression.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Map, Scalar, Value, is_nothing, walk
from stretch_bt.tree import registry
from stretch_bt.tree.declarations import Declarations
from stretch_bt.tree.document import Declared, Signature
from stretch_bt.tree.expression import FUNCTIONS
from stretch_bt.tree.key_types import KeyTypes, KeyWriter
from stretch_bt.tree.place_ports import PlacePort, PlacePorts
from stretch_bt.tree.places import Place, places
from stretch_bt.tree.types import ANY, INT, UNKNOWN, Type, joined

__all__ = ["is_construct", "settle_types"]

_KEY = re.compile(r"\$?([A-Za-z_]\w*)", re.ASCII)
_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
#: words that mean something else in expressions
_WORDS = ("task", "none", "true", "false", "and", "or", "not")
_LOOPS = ("for_each", "repeat", "until")


def is_construct(word: str) -> bool:
    """Whether a word is a construct of the language."""
    from stretch_bt.tree.flow import CONSTRUCTS

    return word in CONSTRUCTS


def settle_types(signature: Signature) -> list[Diagnostic]:
    """Give every input, output and key of a tree its type, after the names of the trees that it calls; once for each tree."""
    if signature.settled:
        return []
    signature.settled = True
    return _Keys(signature).settle()


class _Keys:
    def __init__(self, signature: Signature) -> None:
        self.signature = signature
        self.document = signature.document
        self.places = list(places(signature.body, is_construct))
        self.found: list[Diagnostic] = []
        self.clashes: set[str] = set()
        self.ports = PlacePorts(self.document)

    def settle(self) -> list[Diagnostic]:
        self.keys_of_loops()
        for place in self.places:
            target = self.document.tree(place.word.text)
            if target is not None:
                self.found += settle_types(target)
        self.inputs()
        self.lone_deviations()
        self.signature.read = self.names_read()
        types = KeyTypes(self.signature, *self.written([*self.explicit(), *self.left_out()]))
        every = [declared for name in self.signature.names if (declared := self.signature.declared(name)) is not None]
        return [*self.found, *types.settle(every)]

    def keys_of_loops(self) -> None:
        """Add the keys that loops declare for themselves to the keys of the tree."""
        declarations = Declarations(partial(registry.object_types, self.document.classes.values()), self.found)
        for place in self.places:
            own = place.given.get("keys") if place.word.text in _LOOPS else None
            for key, spec in own if isinstance(own, Map) else ():
                first = self.signature.declared(key.text)
                if not _NAME.fullmatch(key.text):
                    message = f"{key.text!r} cannot be the name of a key"
                    self.found.append(key.mark.error("name", message, "use letters a to z, digits and _"))
                elif first is not None:
                    message = f"${key.text} is declared twice (first on line {first.mark.line})"
                    self.found.append(key.mark.error("key-duplicate", message, "keep one"))
                else:
                    self.check_name(KeyWriter(key.text, key.mark))
                    self.signature.keys[key.text] = declarations.read(key, spec, "key")

    # --- inputs

    def inputs(self) -> None:
        """Give each input without a type the type of the ports that it reaches, and give each input their bounds."""
        for declared in (*self.signature.ins.values(), *self.signature.inouts.values()):
            reached = [port for place in self.places for port in self.ports.reached(place, declared.name)]
            if declared.type is UNKNOWN:
                self.take_type(declared, reached)
            declared.reaches = [port.declared for port in reached if port.declared is not None]
            for port in reached:
                declared.min = max((b for b in (declared.min, port.min) if b is not None), default=None)
                declared.max = min((b for b in (declared.max, port.max) if b is not None), default=None)
            if declared.listed and reached and not _needed(declared.name in self.signature.inouts, reached):
                declared.has_default = declared.may_be_absent = True

    def take_type(self, declared: Declared, reached: list[PlacePort]) -> None:
        types = [port.type for port in reached if port.type is not UNKNOWN]
        if not types and declared.name in self.signature.inouts:
            return  # its writer gives the type
        if not types:
            message = f"no port gives the type of the input {declared.name!r}"
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
        # the narrower of two that meet: both take its values
        declared.type = next((t for t in types if all(u.accepts(t) for u in types)), types[0])

    # --- keys

    def names_read(self) -> set[str]:
        """Return every name that something in the body may read: in an expression or text, or by a record that is left out."""
        found = set(self.signature.outs) | set(_words(self.signature.body))
        for place in self.places:
            for port, given in self.ports.at(place).inputs.items():
                if given.type.is_record and port not in place.given:
                    found.add(port)
        return found

    def explicit(self) -> Iterator[KeyWriter]:
        """Yield the writers of keys that the file names."""
        for place in self.places:
            word, given = place.word.text, place.given
            if word == "set":
                yield from self.of_set(given)
            elif word == "for_each" and isinstance(given.get("as"), Scalar):
                yield from _named(given.get("as"), items=given.get("items"))
                self.check_index(given)
            ports = self.ports.at(place)
            for port, type_ in ports.outputs.items():
                value = given.get(port)
                short = value is not None and is_nothing(value)
                named = [KeyWriter(port, given.key(port).mark, type_)] if short else _named(value, type_)
                yield from (replace(writer, over=port in ports.over) for writer in named)
            if is_construct(word):
                yield from _named(given.get("index"), INT)
                collect = given.get("collect")
                for key, value in collect if isinstance(collect, Map) else ():
                    yield KeyWriter(key.text.removeprefix("$"), key.mark, value=value, each=True)

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

    def of_set(self, given: Map) -> Iterator[KeyWriter]:
        for key, value in given:
            name = key.text.removeprefix("$")
            of = name.removesuffix("_sd")
            beside = of != name and (of in given or f"${of}" in given)
            if not (beside and self.signature.declared(name) is None):
                yield KeyWriter(name, key.mark, value=value)

    def left_out(self) -> Iterator[KeyWriter]:
        """Yield the writers of records that the file leaves out, where the tree reads them."""
        first: dict[str, Place] = {}
        named = self.named_as_ports()
        for place in self.places:
            ports = self.ports.at(place)
            for port, type_ in ports.outputs.items():
                if port in place.given or not type_.is_record:
                    continue
                if port in ports.over:
                    if self.is_free(port, type_):
                        self.signature.left_out.add(port)
                        yield KeyWriter(port, place.word.mark, type_)
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
                elif port in named and named[port].word.text != place.word.text:
                    word = named[port].word
                    what = f"{place.word.text!r} gives {port!r} too, and {word.text!r} (line {word.mark.line}) names it"
                    message = f"{what}: one of them writes over ${port} of the other"
                    hint = f"write '{{{port}}}' if it shall, or give one of them a key of its own"
                    self.found.append(place.word.mark.warning("record-written-over", message, hint))
                self.signature.left_out.add(port)
                yield KeyWriter(port, place.word.mark, type_)

    def named_as_ports(self) -> dict[str, Place]:
        """Return the first place that names each record which it gives, and writes it to the key of that name."""
        found: dict[str, Place] = {}
        for place in self.places:
            ports = self.ports.at(place)
            for port, type_ in ports.outputs.items():
                given = place.given.get(port)
                named = given is not None and (is_nothing(given) or _is(given, port))
                if named and type_.is_record and port not in ports.over:
                    found.setdefault(port, place)
        return found

    def takes(self, name: str, type_: Type) -> bool:
        """Whether a record that is left out is written: something reads its name, and the name is no other thing."""
        return name in self.signature.read and self.is_free(name, type_)

    def is_free(self, name: str, type_: Type) -> bool:
        """Whether a record may be written to the key of its name: the name is no param, input or key of another type."""
        if name in self.document.params or name in self.signature.ins:
            return False
        declared = self.signature.declared(name)
        return declared is None or declared.type is UNKNOWN or declared.type.accepts(type_)

    def written(self, writers: list[KeyWriter]) -> tuple[list[KeyWriter], set[str]]:
        """Add the names that are written to the keys of the tree; return the writers and the names whose type is declared."""
        tables = (self.signature.inouts, self.signature.outs, self.signature.keys)
        known = {name for table in tables for name, declared in table.items() if declared.type is not UNKNOWN}
        for writer in writers:
            self.check_name(writer)
            if self.signature.declared(writer.key) is None and _KEY.fullmatch(writer.key):
                self.signature.keys[writer.key] = Declared(writer.key, UNKNOWN, writer.mark, inferred=True)
        return writers, known

    def check_name(self, writer: KeyWriter) -> None:
        """Note a key that has the name of something else; an input may have the name of a param, which it then hides."""
        name, param = writer.key, self.document.params.get(writer.key)
        hint = "rename one of them"
        if name in self.signature.ins or name in self.clashes:
            return
        if param is not None and writer.over:
            message = f"${name} is a param (line {param.mark.line}), and an inout is written, which a param never is"
            hint = f"copy it to a key first, as in 'set: {{{name}_now: {name}}}', and give '${name}_now'"
        elif param is not None:
            message = f"${name} has the name of a param (line {param.mark.line})"
        elif name in self.document.devices:
            message = f"${name} has the name of a device (line {self.document.devices[name].mark.line})"
        elif name in (*FUNCTIONS, *_WORDS):
            message = f"${name} has the name of something else in expressions"
        else:
            return
        self.clashes.add(name)
        self.found.append(writer.mark.error("key-duplicate", message, hint))


def _is(given: Value, name: str) -> bool:
    return isinstance(given, Scalar) and given.text == f"${name}"


def _needed(written_over: bool, reached: list[PlacePort]) -> bool:
    """Whether a tree needs an input: one of its ports does, or the first one of what is written over after that."""
    return reached[0].needed if written_over else any(port.needed for port in reached)


def _named(key: Value | None, type_: Type | None = None, items: Value | None = None) -> Iterator[KeyWriter]:
    """Yield the writer of the key that a value names, of a type or of the type of the items of a list."""
    match = _KEY.fullmatch(key.text) if isinstance(key, Scalar) else None
    if match is not None and isinstance(key, Scalar):
        yield KeyWriter(match[1], key.mark, type_, items, item=items is not None)


def _words(body: Value) -> Iterator[str]:
    """Yield the words of every value that is written in a body, and the keys that stand short."""
    for key, value in walk(body):
        if isinstance(value, Scalar):
            if key is not None and is_nothing(value):
                yield key.text
            else:
                yield from _NAME.findall(value.text)
