"""Reading the body of a tree: nodes, constructs and calls, with every port wired and typed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Map, Mark, Scalar, Seq, Value, did_you_mean
from stretch_bt.tree import registry
from stretch_bt.tree.document import Declared, Signature
from stretch_bt.tree.expression import Expression, ExpressionError, bind, names, parse, typecheck
from stretch_bt.tree.expression.typecheck import Origin
from stretch_bt.tree.flow import CONSTRUCTS, Call, Leaf, Part, Wire
from stretch_bt.tree.flow.for_each import ForEach
from stretch_bt.tree.flow.groups import Sequence
from stretch_bt.tree.flow.guard import Guard, SkipIf
from stretch_bt.tree.flow.log import Log
from stretch_bt.tree.flow.repeat import Retry
from stretch_bt.tree.flow.set_keys import SetKeys
from stretch_bt.tree.flow.timeout import Timeout
from stretch_bt.tree.ports import MISSING, Port, Role
from stretch_bt.tree.registry import RESERVED, NodeInfo
from stretch_bt.tree.scope import TreeScope
from stretch_bt.tree.types import Family, Type
from stretch_bt.tree.values import Refused, check_bounds, literal, written
from stretch_bt.units import NUMBER

__all__ = ["Reader"]

_LITERAL = re.compile(
    rf"\s*{NUMBER}\s*(?:[A-Za-z%µ][\w/%^µ²³]*|1/[A-Za-z]\w*)?\s*|\s*[-+]?\.(?:inf|nan)\s*", re.IGNORECASE
)
#: modifiers, from the innermost to the outermost
_AROUND = (
    ("timeout", Timeout.around),
    ("retry", Retry.around),
    ("while", Guard.around),
    ("guard", Guard.around),
    ("skip_if", SkipIf.around),
    ("log", Log.around),
)


class Reader:
    """Reads the bodies of one tree; mistakes are noted and reading goes on."""

    def __init__(self, signature: Signature) -> None:
        self.signature = signature
        self.document = signature.document
        self.scope = TreeScope(signature)
        self.diagnostics: list[Diagnostic] = []

    def error(self, mark: Mark, code: str, message: str, hint: str = "") -> None:
        """Note a mistake."""
        self.diagnostics.append(mark.error(code, message, hint))

    # --- bodies

    def body(self, value: Value) -> Part | None:
        """Read one place of a tree: `{press: {...}}`, a bare name, or a list run as a sequence."""
        if isinstance(value, Seq):
            return Sequence(value.mark, self.children(value, value.mark, "sequence"))
        if isinstance(value, Scalar):
            if value.value is None:
                self.error(
                    value.mark,
                    "body-missing",
                    "there is no node here",
                    "write '- press: {depth: 10 mm}', or remove the dash",
                )
                return None
            return self.place(value, Map((), value.mark), {})
        kinds: list[tuple[Scalar, Value]] = [(key, v) for key, v in value if key.text not in RESERVED]
        if not kinds:
            kinds += [(k, v) for k, v in value if k.text in CONSTRUCTS and isinstance(v, Map) and "do" in v][:1]
        if len(kinds) != 1:
            names_ = ", ".join(repr(k.text) for k, _ in kinds) or "nothing"
            at = kinds[1][0].mark if kinds else value.mark
            self.error(
                at, "body", f"a place in a tree names one node, here {names_}", "begin each node with its own '- '"
            )
            return None
        key, given = kinds[0]
        beside = {k.text: v for k, v in value if k is not key}
        return self.place(key, given, beside)

    def children(self, value: Value, mark: Mark, what: str) -> list[Part]:
        """Read a list of at least one place."""
        if not isinstance(value, Seq):
            self.error(value.mark, "type-mismatch", f"{what!r} takes a list of nodes", "begin each with '- '")
            return []
        if not value.items:
            self.error(mark, "empty", f"{what!r} has no children", "add a node, or remove it")
        return [part for item in value.items if (part := self.body(item)) is not None]

    def place(self, key: Scalar, given: Value, beside: dict[str, Value]) -> Part | None:
        """Read a node, construct or call with the reserved words inside and beside it."""
        modifiers = dict(beside)
        if isinstance(given, Map) and key.text != "set":
            inside = {k.text for k, _ in given} & set(RESERVED)
            modifiers |= {k.text: v for k, v in given if k.text in inside}
            given = Map(tuple((k, v) for k, v in given if k.text not in inside), given.mark)
        part = self.kind(key, given)
        if part is None:
            return None
        part.name = self.name(modifiers.get("name")) or part.name
        if "finally" in modifiers:
            self.error(
                modifiers["finally"].mark,
                "finally",
                "'finally' belongs to a tree, not to a node",
                "move it under the tree's name",
            )
        for word, around in _AROUND:
            if word in modifiers:
                part = around(self, part, modifiers[word])
        return part

    def kind(self, key: Scalar, given: Value) -> Part | None:
        """Find out what a name is, and read it."""
        construct = CONSTRUCTS.get(key.text)
        if construct is not None:
            return construct.read(self, key.mark, given)  # type: ignore[attr-defined, no-any-return]
        if key.text == "run":
            return self.explicit_call(key, given)
        target = self.document.tree(key.text)
        if target is not None:
            return self.call(target, key.mark, given)
        info = registry.lookup(key.text) or self.prefixed(key.text)
        if info is not None:
            return self.leaf(info, key.mark, given)
        known = [*registry.load_all(), *self.document.tree_names(), *CONSTRUCTS]
        hint = did_you_mean(key.text, known) or "`stretch-bt nodes` lists all nodes"
        self.error(key.mark, "node-unknown", f"there is no node or tree {key.text!r}", hint)
        return None

    @staticmethod
    def prefixed(name: str) -> NodeInfo | None:
        """Find a node written with the name of the module that it was imported under."""
        _, dot, last = name.rpartition(".")
        return registry.lookup(last) if dot else None

    def name(self, value: Value | None) -> str | None:
        """Read the name given to a place."""
        if value is None:
            return None
        if isinstance(value, Scalar) and re.fullmatch(r"[A-Za-z_][\w-]*", value.text):
            return value.text
        self.error(value.mark, "name", "a name is one word of letters, digits, _ and -", "write 'name: force_limit'")
        return None

    # --- nodes and calls

    def port_map(self, value: Value, mark: Mark, what: str) -> Map | None:
        """Return the wiring written after a name; nothing written means none."""
        if isinstance(value, Map):
            return value
        if isinstance(value, Scalar) and value.value is None and not value.quoted:
            return Map((), mark)
        self.error(
            value.mark, "type-mismatch", f"{what!r} takes a mapping of ports", f"write '{what}: {{port: value}}'"
        )
        return None

    def leaf(self, info: NodeInfo, mark: Mark, value: Value) -> Part | None:
        """Read a node and wire its ports."""
        ports = self.port_map(value, mark, info.name)
        found = Leaf(mark, info)
        if ports is None:
            return found
        outputs = info.outputs
        for key, given in ports:
            declared = info.ports.get(key.text)
            if declared is not None and declared.role is Role.INPUT:
                self.input(found.inputs, key, given, info.types[key.text], f"{info.name}.{key.text}", declared)
            elif declared is not None and declared.role is Role.DEVICE:
                self.device(found, declared, given)
            elif key.text in outputs:
                self.sink(found.outputs, key, given, outputs[key.text], f"{info.name}.{key.text}")
            else:
                self.unknown_port(key, info.name, [*info.ports, *outputs])
        self.complete(found, ports, mark)
        return found

    def complete(self, found: Leaf, ports: Map, mark: Mark) -> None:
        """Note what is missing, and find the devices that the tree declares."""
        for declared in found.info.ports.values():
            if declared.required and declared.name not in ports:
                type_ = found.info.types[declared.name]
                self.error(
                    mark,
                    "port-missing",
                    f"{found.info.name!r} needs {declared.name!r} ({type_})",
                    f"add '{declared.name}: ...'",
                )
            elif declared.role is Role.DEVICE and declared.name not in ports:
                self.default_device(found, declared, mark)

    def unknown_port(self, key: Scalar, what: str, known: list[str]) -> None:
        """Note a port that is not there."""
        hint = did_you_mean(key.text, known) or f"ports of {what}: {', '.join(known) or 'none'}"
        self.error(key.mark, "port-unknown", f"{what!r} has no port {key.text!r}", hint)

    def device(self, found: Leaf, declared: Port, value: Value) -> None:
        """Wire a device port to a declared device."""
        name = value.text.removeprefix("$") if isinstance(value, Scalar) else ""
        decl = self.document.devices.get(name)
        if decl is None:
            self.error(
                value.mark,
                "device-undeclared",
                f"no device {name!r} is declared",
                did_you_mean(name, self.document.devices),
            )
            return
        decl.used = True
        wanted = found.info.types[declared.name].name
        if decl.interface.__name__ != wanted:
            message = f"{found.info.name}.{declared.name} takes {wanted}, but {name!r} is {decl.interface.__name__}"
            self.error(value.mark, "type-mismatch", message, "name another device")
        found.devices[declared.name] = name

    def default_device(self, found: Leaf, declared: Port, mark: Mark) -> None:
        """Wire a device port that is not written: the device of its name, or the only one of its kind."""
        wanted = found.info.types[declared.name].name
        fitting = [d for d in self.document.devices.values() if d.interface.__name__ == wanted]
        named_so = [d for d in fitting if d.name == declared.name]
        chosen = named_so or fitting
        if len(chosen) == 1:
            chosen[0].used = True
            found.devices[declared.name] = chosen[0].name
        elif not declared.optional:
            what = f"{found.info.name!r} uses a {wanted}, and the file declares {'none' if not chosen else 'several'}"
            hint = (
                f"add 'devices: {{{declared.name}: {wanted}}}'"
                if not chosen
                else f"write '{declared.name}: {chosen[0].name}'"
            )
            self.error(mark, "device-undeclared", what, hint)

    def explicit_call(self, key: Scalar, value: Value) -> Part | None:
        """Read `{run: tree, with: {...}}`."""
        given = value if isinstance(value, Map) else Map(((Scalar("tree", False, value.mark), value),), value.mark)
        fields = self.fields(given, key.mark, "run", required=("tree",), optional=("with",))
        tree = fields["tree"] if fields else None
        if fields is None or not isinstance(tree, Scalar):
            return None
        target = self.document.tree(tree.text)
        if target is None:
            hint = did_you_mean(tree.text, self.document.tree_names())
            self.error(tree.mark, "node-unknown", f"there is no tree {tree.text!r}", hint)
            return None
        return self.call(target, tree.mark, fields.get("with", Map((), key.mark)))

    def call(self, target: Signature, mark: Mark, value: Value) -> Part | None:
        """Read a call of a tree and wire what crosses its border."""
        ports = self.port_map(value, mark, target.name)
        found = Call(mark, target)
        for key, given in ports or ():
            if key.text in target.ins:
                declared = target.ins[key.text]
                self.input(found.inputs, key, given, declared.type, f"{target.name}.{key.text}", declared)
            elif key.text in target.outs:
                self.sink(found.outputs, key, given, target.outs[key.text].type, f"{target.name}.{key.text}")
            else:
                self.unknown_port(key, target.name, [*target.ins, *target.outs])
        for declared in target.ins.values():
            if ports is not None and not declared.has_default and declared.name not in ports:
                self.error(
                    mark,
                    "port-missing",
                    f"{target.name!r} needs {declared.name!r} ({declared.type})",
                    f"add '{declared.name}: ...'",
                )
        return found

    # --- values

    def fields(
        self, value: Value, mark: Mark, what: str, required: tuple[str, ...] = (), optional: tuple[str, ...] = ()
    ) -> dict[str, Value] | None:
        """Return the fields of a construct, or None when one is missing."""
        if not isinstance(value, Map):
            self.error(value.mark, "type-mismatch", f"{what!r} takes a mapping", f"write its {', '.join(required)}")
            return None
        for key, _ in value:
            if key.text not in (*required, *optional):
                self.error(
                    key.mark,
                    "port-unknown",
                    f"{what!r} has no {key.text!r}",
                    did_you_mean(key.text, (*required, *optional)),
                )
        missing = [name for name in required if name not in value]
        for name in missing:
            self.error(mark, "port-missing", f"{what!r} needs {name!r}", f"add '{name}: ...'")
        return None if missing else {k.text: v for k, v in value}

    def input(
        self, wires: dict[str, Wire], key: Scalar, value: Value, type_: Type, what: str, bounds: Port | Declared
    ) -> None:
        """Wire an input port."""
        wire = self.value(value, type_, what, low=bounds.min, high=bounds.max)
        if wire is not None:
            wires[key.text] = wire

    def sink(self, sinks: dict[str, tuple[str, Mark]], key: Scalar, value: Value, type_: Type, what: str) -> None:
        """Wire an output port."""
        name = self.output(value, type_, what)
        if name is not None:
            sinks[key.text] = (name, value.mark)

    def output(self, value: Value, type_: Type | None, what: str) -> str | None:
        """Return the key that an output writes."""
        text = value.text if isinstance(value, Scalar) else ""
        name = text.removeprefix("$")
        if not re.fullmatch(r"\$[A-Za-z_]\w*", text):
            hint = f"write '${name}'" if self.signature.declared(name) else "write '$key', with a key of this tree"
            self.error(
                value.mark, "output-literal", f"{what} is an output, so it takes a $key, not {text or 'this'!r}", hint
            )
            return None
        declared = self.signature.declared(name)
        if declared is None:
            hint = did_you_mean(name, self.signature.names)
            if "did you mean" not in hint:
                hint = f"declare it: 'keys: {{{name}: {type_ or 'Length'}}}'"
            self.error(value.mark, "key-undeclared", f"${name} is not declared in tree {self.signature.name!r}", hint)
            return None
        if name in self.signature.ins:
            self.error(
                value.mark,
                "input-written",
                f"${name} is an input of tree {self.signature.name!r} and cannot be written",
                "use another key",
            )
            return None
        if type_ is not None and not declared.type.accepts(type_):
            message = f"${name} is {declared.type} (line {declared.mark.line}) but {what} gives {type_}"
            self.error(value.mark, "type-mismatch", message, f"use a key of type {type_}")
            return None
        return name

    def value(
        self, value: Value, type_: Type, what: str, low: float | None = None, high: float | None = None
    ) -> Wire | None:
        """Return what feeds an input: a literal, or an expression over keys, parameters and readings."""
        try:
            if isinstance(value, Scalar) and self.is_expression(value, type_):
                wire = self.expression(value, type_, what)
            elif isinstance(value, Seq) and type_.family is Family.LIST:
                wire = self.list_value(value, type_, what)
            else:
                wire = Wire(value.mark, value=literal(value, type_, what))
            if wire is not None and wire.is_constant:
                check_bounds(wire.value, type_, low, high, value.mark, what)
        except Refused as refused:
            self.diagnostics.append(refused.diagnostic)
            return None
        if wire is not None and not wire.text:
            wire.text = written(value)
        return wire

    def list_value(self, value: Seq, type_: Type, what: str) -> Wire | None:
        """Return a list whose items are literals or parameters."""
        assert type_.item is not None
        items = [self.value(item, type_.item, what) for item in value.items]
        if any(item is None for item in items):
            return None
        for item in items:
            if item is not None and not item.is_constant:
                self.error(
                    item.mark,
                    "type-mismatch",
                    f"{what}: an item of a list must be known at load",
                    "use literals or params",
                )
                return None
        return Wire(value.mark, value=[item.value for item in items if item is not None])

    @staticmethod
    def is_expression(value: Scalar, type_: Type) -> bool:
        """Whether a scalar is to be read as an expression rather than as a literal."""
        if value.text.startswith("$"):
            return True
        if type_.family in (Family.STR, Family.ENUM):
            return False
        if _LITERAL.fullmatch(value.text):
            return False
        return isinstance(value.value, str)

    def expression(self, value: Value, type_: Type, what: str) -> Wire | None:
        """Read an expression of the wanted type; constants are worked out now."""
        if not isinstance(value, Scalar):
            self.error(value.mark, "type-mismatch", f"{what} takes an expression", "write it as text, in quotes")
            return None
        try:
            found = parse(value.text)
            given = typecheck(found, self.scope)
        except ExpressionError as error:
            self.error(_inside(value, error.offset, error.length), error.code, error.message, error.hint)
            return None
        if not type_.accepts(given):
            self.mismatch(value, found, given, type_, what)
            return None
        return self.wire(value, found)

    def mismatch(self, value: Scalar, expression: Expression, given: Type, wanted: Type, what: str) -> None:
        """Note a value of the wrong type."""
        if wanted.family is Family.QUANTITY and given.is_number and not any(given.dimension):
            self.error(
                value.mark,
                "unit-missing",
                f"{what} takes {wanted}, but {value.text!r} has no unit",
                "multiply it by a unit",
            )
            return
        hint = f"use a value of type {wanted}"
        symbol = self.scope.resolve(expression.parts) if hasattr(expression, "parts") else None
        declared = self.signature.declared(symbol.name) if symbol is not None and not isinstance(symbol, str) else None
        where = f" (declared on line {declared.mark.line})" if declared else ""
        self.error(value.mark, "type-mismatch", f"{value.text} is {given}{where} but {what} takes {wanted}", hint)

    def wire(self, value: Scalar, expression: Expression) -> Wire | None:
        """Return the wire of a checked expression, with what it reads."""
        wire = Wire(value.mark, expression, text=value.text)
        constant = True
        for name in names(expression):
            symbol = self.scope.resolve(name.parts)
            assert not isinstance(symbol, str)
            if symbol.origin in (Origin.KEY, Origin.SD):
                wire.reads += ((symbol.name, _inside(value, name.offset, name.length)),)
            elif symbol.origin is Origin.READING:
                wire.readings += (symbol.name,)
            constant = constant and symbol.origin is Origin.PARAM
        if not constant:
            return wire
        try:
            wire.value = bind(expression, ParamEnvironment(self.scope))()
        except (ArithmeticError, TypeError, IndexError, ValueError) as error:
            self.error(
                value.mark,
                "expression",
                f"{value.text!r} has no value: {error}",
                "change the parameters, or the expression",
            )
            return None
        return None if wire.value is None or wire.value is MISSING else wire

    def writes(self, part: Part) -> Iterator[tuple[str, str, Mark]]:
        """Yield every key that a part writes, with who writes it and where."""
        for inner in part.walk():
            if isinstance(inner, Leaf | Call):
                for key, mark in inner.outputs.values():
                    yield key, inner.label, mark
            elif isinstance(inner, SetKeys):
                for key, mark in inner.marks.items():
                    yield key, "set", mark
            elif isinstance(inner, ForEach):
                yield inner.key, "for_each", inner.key_mark


class ParamEnvironment:
    """Values of parameters, for expressions that need nothing else."""

    def __init__(self, scope: TreeScope) -> None:
        self.scope = scope

    def source(self, parts: tuple[str, ...]) -> tuple[Callable[[], Any], tuple[str, ...]]:
        """Return the value of a parameter."""
        symbol = self.scope.resolve(parts)
        assert not isinstance(symbol, str)
        value = symbol.value
        return (lambda: value), parts[symbol.used :]


def _inside(value: Scalar, offset: int, length: int) -> Mark:
    """Return the place of a part of a scalar; a quote shifts it by one, a folded text keeps its start."""
    if value.mark.length < len(value.text):
        return value.mark
    return value.mark.shifted(offset + (1 if value.quoted else 0), max(length, 1))
