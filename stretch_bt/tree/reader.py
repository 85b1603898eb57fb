"""Reading the body of a tree: nodes, constructs and calls, with every port wired and typed."""

from __future__ import annotations

import re
from collections.abc import Iterator

from stretch_bt.source import Map, Mark, Scalar, Seq, Value, closest, did_you_mean, is_nothing, unknown_key
from stretch_bt.tree import registry
from stretch_bt.tree.document import Signature
from stretch_bt.tree.flow import CONSTRUCTS, Broken, Call, Leaf, Part
from stretch_bt.tree.flow.for_each import ForEach
from stretch_bt.tree.flow.groups import Sequence
from stretch_bt.tree.flow.guard import Guard, SkipIf
from stretch_bt.tree.flow.log import Log
from stretch_bt.tree.flow.repeat import Repeat, Retry
from stretch_bt.tree.flow.set_keys import SetKeys
from stretch_bt.tree.flow.timeout import Timeout
from stretch_bt.tree.flow.until import Until
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.registry import RESERVED, RETIRED, NodeInfo
from stretch_bt.tree.types import Type
from stretch_bt.tree.values import braces, sample, written
from stretch_bt.tree.wiring import Wiring

__all__ = ["Reader"]

#: words of a node that stand beside it, with where they are and what they are given
Words = dict[str, tuple[Scalar, Value]]

#: constructs in which a reserved word belongs to what stands inside: a key to be set, a node whose result is changed
_OWN_WORDS = ("set", "invert", "force_success", "force_failure")
#: constructs in whose braces a name may stand
_CONDITIONS = ("check", "guard")
#: modifiers, from the innermost to the outermost
_AROUND = (
    ("timeout", Timeout.around),
    ("retry", Retry.around),
    ("guard", Guard.around),
    ("skip_if", SkipIf.around),
    ("log", Log.around),
)


class Reader(Wiring):
    """Reads the bodies of one tree; mistakes are noted and reading goes on."""

    # --- bodies

    def __init__(self, signature: Signature) -> None:
        super().__init__(signature)
        self._bodies: dict[int, tuple[Value, Part | None]] = {}

    def body(self, value: Value) -> Part | None:
        """Read one place of a tree: `{press: {...}}`, a bare name, or a list run as a sequence; each is read once."""
        if id(value) not in self._bodies:
            self._bodies[id(value)] = value, self.read_body(value)
        return self._bodies[id(value)][1]

    def read_body(self, value: Value) -> Part | None:
        """Read one place of a tree."""
        if isinstance(value, Seq):
            return Sequence(value.mark, self.children(value, value.mark, "sequence"))
        if isinstance(value, Scalar):
            if value.value is None:
                hint = "write '- press: {depth: 10 mm}', or remove the dash"
                self.error(value.mark, "body-missing", "there is no node here", hint)
                return None
            return self.place(value, Map((), value.mark), {})
        value = self.spelt(value)
        words = {key.text: (key, v) for key, v in value if key.text in RESERVED}
        kinds: list[tuple[Scalar, Value]] = [(key, v) for key, v in value if key.text not in RESERVED]
        if "run" in value and "with" in value and isinstance(value.get("run"), Scalar):
            pairs = (
                (Scalar("tree", False, value.key("run").mark), value.get("run")),
                (value.key("with"), value.get("with")),
            )
            call = Map(tuple((k, v) for k, v in pairs if v is not None), value.mark)
            kinds = [(value.key("run"), call), *((k, v) for k, v in kinds if k.text not in ("run", "with"))]
        if not kinds:  # a reserved word that is a construct too, as in `timeout: {after: 1 s, do: ...}`
            forms = ((k, v) for k, v in words.values() if k.text in CONSTRUCTS and isinstance(v, Map) and "do" in v)
            kinds += list(forms)[:1]
        known = [(key, v) for key, v in kinds if self.is_known(key.text)]
        if len(known) == 1 and len(kinds) > 1:
            self.strange_words([pair for pair in kinds if pair not in known], [*words])
            kinds = known
        if len(kinds) != 1:
            names = ", ".join(repr(k.text) for k, _ in kinds) or "nothing"
            at = kinds[1][0].mark if kinds else value.mark
            self.error(
                at, "body", f"a place in a tree names one node, here {names}", "begin each node with its own '- '"
            )
            return None
        key, given = kinds[0]
        words.pop(key.text, None)
        return self.place(key, given, words)

    def spelt(self, value: Map) -> Map:
        """Put right the words of older files, and note them."""
        if not any(word in value for word in RETIRED):
            return value
        pairs = []
        for key, given in value:
            if (word := RETIRED.get(key.text)) is not None:
                self.error(key.mark, "retired", f"{key.text!r} is no longer a word of the language", f"write {word!r}")
                key = Scalar(word, False, key.mark)
            pairs.append((key, given))
        return Map(tuple(pairs), value.mark)

    def strange_words(self, pairs: list[tuple[Scalar, Value]], taken: list[str]) -> None:
        """Note what stands beside a node and is neither a reserved word nor a node."""
        for key, value in pairs:
            guess = closest(key.text, [word for word in RESERVED if word not in taken])
            hint = f"did you mean {guess!r}?" if guess else "indent it further if it is a port; else begin it with '- '"
            if guess is None and unknown_key(key, value, ()):
                hint = unknown_key(key, value, ())
            self.error(key.mark, "key-unknown", f"{key.text!r} is neither a node nor a word beside one", hint)

    def children(self, value: Value, mark: Mark, what: str) -> list[Part]:
        """Read a list of at least one place."""
        if not isinstance(value, Seq):
            self.error(value.mark, "type-mismatch", f"{what!r} takes a list of nodes", "begin each with '- '")
            return []
        if not value.items:
            self.error(mark, "empty", f"{what!r} has no children", "add a node, or remove it")
        return [part for item in value.items if (part := self.body(item)) is not None]

    def place(self, key: Scalar, given: Value, beside: Words) -> Part | None:
        """Read a node, construct or call with the reserved words inside and beside it."""
        words = dict(beside)
        if isinstance(given, Map) and key.text not in _OWN_WORDS:
            given = self.spelt(given)
            for inner, value in given:
                if inner.text in RESERVED:
                    self.word_inside(key, inner, value, words)
            given = Map(tuple((k, v) for k, v in given if k.text not in RESERVED), given.mark)
        part = self.kind(key, given)
        part.name = self.name(words["name"][1]) if "name" in words else None
        if "finally" in words:
            message, hint = "'finally' belongs to a tree, not to a node", "move it under the tree's name"
            self.error(words["finally"][0].mark, "finally", message, hint)
        if "doc" in words and not isinstance(words["doc"][1], Scalar):
            self.error(words["doc"][1].mark, "type-mismatch", "'doc' takes text", "write one sentence")
        for word, around in _AROUND:
            if word in words:
                part = around(self, part, words[word][1])
        return part

    def word_inside(self, key: Scalar, inner: Scalar, value: Value, words: Words) -> None:
        """Take a word that stands among the ports: the name of a condition; any other belongs beside the node."""
        if inner.text in words:
            message = f"{inner.text!r} is given inside and beside the node"
            self.error(inner.mark, "key-duplicate", message, "keep one")
            return
        words[inner.text] = (inner, value)
        if not (inner.text == "name" and key.text in _CONDITIONS):
            message = f"{inner.text!r} stands among the ports of {key.text!r}"
            hint = f"put it beside the node: '{{{key.text}: ..., {inner.text}: {written(value)}}}'"
            self.error(inner.mark, "retired", message, hint)

    def is_known(self, name: str) -> bool:
        """Whether a name is that of a construct, a tree or a node."""
        return name in CONSTRUCTS or name == "run" or bool(self.document.tree(name) or self.node(name))

    def kind(self, key: Scalar, given: Value) -> Part:
        """Find out what a name is, and read it."""
        return self.known_kind(key, given) or self.broken(key, given)

    def known_kind(self, key: Scalar, given: Value) -> Part | None:
        """Read what a name is; None, with an error, when it cannot be read."""
        construct = CONSTRUCTS.get(key.text)
        if construct is not None:
            return construct.read(self, key.mark, given)  # type: ignore[attr-defined, no-any-return]
        if key.text == "run":
            return self.explicit_call(key, given)
        target = self.document.tree(key.text)
        if target is not None:
            return self.call(target, key.mark, given)
        info = self.node(key.text)
        if info is not None:
            return self.leaf(info, key.mark, given)
        if key.text.partition(".")[0] in self.document.doubtful:
            return None
        known = [*registry.load_all(), *self.document.tree_names(), *CONSTRUCTS, "run"]
        guess = closest(registry.snake_case(key.text), known)
        hint = f"did you mean {guess!r}?" if guess else did_you_mean(key.text, known)
        hint = hint or "`stretch-bt nodes` lists all nodes"
        self.error(key.mark, "node-unknown", f"there is no node or tree {key.text!r}", hint)
        return None

    def broken(self, key: Scalar, given: Value) -> Broken:
        """Keep what can be read of a place with a mistake, so that the rest of the tree is judged as if it were there."""
        found = Broken(key.mark, key.text)
        places = list(given.items) if isinstance(given, Seq) else []
        pairs = list(given.pairs) if isinstance(given, Map) else []
        for name, value in pairs:
            if isinstance(value, Scalar) and value.text.startswith("$"):
                found.keys[value.text[1:]] = value.mark
            elif key.text == "set":
                found.keys[name.text.removeprefix("$")] = name.mark
            elif name.text == "do":
                places.append(value)
            elif name.text == "children" and isinstance(value, Seq):
                places += value.items
            elif name.text == "with" and isinstance(value, Map):
                pairs += value.pairs
        found.parts = [part for value in places if (part := self.body(value)) is not None]
        return found

    def node(self, name: str) -> NodeInfo | None:
        """Find a node by what the file calls it."""
        return registry.find(name, self.document.modules)

    def name(self, value: Value | None) -> str | None:
        """Read the name given to a place."""
        if value is None:
            return None
        if isinstance(value, Scalar) and re.fullmatch(r"[A-Za-z_][\w-]*", value.text) and value.text != "finally":
            return value.text
        word = re.sub(r"\W+", "_", value.text).strip("_") if isinstance(value, Scalar) else ""
        if word == "finally":
            self.error(value.mark, "name", "'finally' is reserved for the end of a tree", "write 'name: at_the_end'")
            return None
        hint = f"write '{word}'" if re.match(r"[A-Za-z_]", word) else "write 'name: force_limit'"
        self.error(value.mark, "name", "a name is one word of letters, digits, _ and -", hint)
        return None

    # --- nodes and calls

    def port_map(self, value: Value, mark: Mark, what: str, required: list[str]) -> Map | None:
        """Return the wiring written after a name; nothing written means none."""
        if isinstance(value, Map):
            return value
        if isinstance(value, Scalar) and value.value is None and not value.quoted:
            return Map((), mark)
        given = value.text if isinstance(value, Scalar) and len(required) == 1 else "..."
        ports = ", ".join(f"{name}: {given}" for name in required) or "port: value"
        self.error(value.mark, "type-mismatch", f"{what!r} takes a mapping of ports", f"write '{what}: {{{ports}}}'")
        return None

    def leaf(self, info: NodeInfo, mark: Mark, value: Value) -> Part | None:
        """Read a node and wire its ports."""
        required = [p.name for p in info.ports.values() if p.required]
        ports = self.port_map(value, mark, info.name, required)
        found = Leaf(mark, info)
        if ports is None:
            return None
        outputs = info.outputs
        meant = self.unknown(ports, info.name, [*info.ports, *outputs], required)
        for key, written in ports:
            declared = info.ports.get(key.text)
            if declared is not None and declared.role is Role.DEVICE:
                if not is_nothing(written):
                    self.device(found, declared, written)
                continue
            given = self.full(key, written)
            if given is None:
                continue
            if declared is not None and declared.role is Role.INPUT:
                self.input(found.inputs, key, given, info.types[key.text], f"{info.name}.{key.text}", declared)
            elif key.text in outputs:
                self.sink(found.outputs, key, given, outputs[key.text], f"{info.name}.{key.text}")
        self.records_in(found, {p.name: (info.types[p.name], p.required) for p in info.of(Role.INPUT)}, ports, mark)
        self.records_out(found, outputs, ports, mark)
        self.lost_errors(found)
        for name in required:
            carried = name.endswith("_sd") and found.inputs.get(name.removesuffix("_sd"))
            if name not in ports and name not in meant and name not in found.inputs and not (carried and carried.source):
                self.missing(mark, info.name, name, info.types[name])
        for declared in info.of(Role.DEVICE):
            if declared.name not in ports or is_nothing(ports.get(declared.name) or Map((), mark)):
                self.default_device(found, declared, mark)
        return found

    def lost_errors(self, found: Leaf) -> None:
        """Warn of each expression whose value has no error where the node asks for one."""
        for name, wire in found.inputs.items():
            port = found.info.ports.get(f"{name}_sd")
            if port is None or port.name in found.inputs or wire.is_constant or wire.source is not None:
                continue
            message = f"{wire.text!r} is worked out, so that it has no error, and {port.name!r} keeps its default"
            hint = f"add '{port.name}: ...', or give the error beside the value in a 'set'"
            self.diagnostics.append(wire.mark.warning("deviation-lost", message, hint))

    def records_in(self, found: Leaf | Call, inputs: dict[str, tuple[Type, bool]], ports: Map, mark: Mark) -> None:
        """Wire each record that is left out to the key of its name, where there is one."""
        for name, (type_, required) in inputs.items():
            declared = self.signature.declared(name)
            if name not in ports and type_.is_record and declared is not None and type_.accepts(declared.type):
                wire = self.value(Scalar(f"${name}", False, mark), type_, f"{found.label}.{name}")
                if wire is not None:
                    wire.optional = not required
                    found.inputs[name] = wire

    def records_out(self, found: Leaf | Call, outputs: dict[str, Type], ports: Map, mark: Mark) -> None:
        """Write each record that is left out to the key of its name, where something reads that."""
        for name, type_ in outputs.items():
            declared = self.signature.declared(name)
            if name in ports or not type_.is_record or declared is None or not declared.type.accepts(type_):
                continue
            if name in self.signature.read and name not in self.signature.ins:
                found.outputs[name] = (name, mark)
                found.left_out.add(name)

    def missing(self, mark: Mark, what: str, name: str, type_: Type) -> None:
        """Note an input that must be given and is not."""
        hint = f"add '{name}: {sample(type_)}'"
        if type_.is_record:
            givers = [info.name for info in registry.load_all().values() if type_ in info.outputs.values()]
            hint = f"nothing before it writes {name!r}; {', '.join(map(repr, givers[:3])) or 'some node'} gives one, or {hint}"
        self.error(mark, "port-missing", f"{what!r} needs {name!r} ({type_})", hint)

    def device(self, found: Leaf, declared: Port, value: Value) -> None:
        """Wire a device port to a declared device."""
        name = value.text.removeprefix("$") if isinstance(value, Scalar) else ""
        decl = self.document.devices.get(name)
        if decl is None:
            if name in self.document.doubtful:
                return
            self.error(
                value.mark,
                "device-undeclared",
                f"no device {name!r} is declared",
                braces(value)
                or did_you_mean(name, self.document.devices)
                or self.fitting(found.info.types[declared.name].name),
            )
            return
        decl.used = True
        wanted = found.info.types[declared.name].name
        if decl.interface.__name__ != wanted:
            message = f"{found.info.name}.{declared.name} takes {wanted}, but {name!r} is {decl.interface.__name__}"
            self.error(value.mark, "type-mismatch", message, self.fitting(wanted))
        found.devices[declared.name] = name

    def fitting(self, wanted: str) -> str:
        """Return which device of the file is of the wanted kind."""
        names = [d.name for d in self.document.devices.values() if d.interface.__name__ == wanted]
        return f"write '{names[0]}'" if names else f"declare one: 'devices: {{name: {wanted}}}'"

    def default_device(self, found: Leaf, declared: Port, mark: Mark) -> None:
        """Wire a device port that is not written: the device of its name, or the only one of its kind."""
        wanted = found.info.types[declared.name].name
        fitting = [d for d in self.document.devices.values() if d.interface.__name__ == wanted]
        named_so = [d for d in fitting if d.name == declared.name]
        chosen = named_so or fitting
        if len(chosen) == 1:
            chosen[0].used = True
            found.devices[declared.name] = chosen[0].name
        elif not declared.optional and not (self.document.doubtful and not chosen):
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
        required = [d.name for d in target.ins.values() if not d.has_default and not d.doubtful]
        ports = self.port_map(value, mark, target.name, required)
        if ports is None:
            return None
        found = Call(mark, target)
        meant = self.unknown(ports, target.name, [*target.ins, *target.outs], required)
        for key, written in ports:
            given = self.full(key, written)
            if given is None:
                continue
            if key.text in target.ins:
                declared = target.ins[key.text]
                self.input(found.inputs, key, given, declared.type, f"{target.name}.{key.text}", declared)
            elif key.text in target.outs and target.outs[key.text].scene:
                message = f"the scene alone knows {key.text!r} of {target.name!r}, and no tree may read it"
                self.error(key.mark, "output-of-scene", message, "leave it out")
            elif key.text in target.outs:
                self.sink(found.outputs, key, given, target.outs[key.text].type, f"{target.name}.{key.text}")
        self.records_in(found, {d.name: (d.type, not d.has_default) for d in target.ins.values()}, ports, mark)
        self.records_out(found, {d.name: d.type for d in target.outs.values() if not d.scene}, ports, mark)
        for name in required:
            if name not in ports and name not in meant and name not in found.inputs:
                self.missing(mark, target.name, name, target.ins[name].type)
        return found

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
                yield from ((key, "for_each", mark) for key, mark in inner.passes.marks.items())
            elif isinstance(inner, Until | Repeat):
                yield from ((key, inner.keyword, mark) for key, mark in inner.passes.marks.items())
            elif isinstance(inner, Broken):
                for key, mark in inner.keys.items():
                    yield key, inner.label, mark
