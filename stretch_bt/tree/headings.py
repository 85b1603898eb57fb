"""Reading the headings of a tree file: imports, params, devices, keys and the borders of its trees."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from stretch_bt.errors import FileError
from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.hardware.own_modules import ModuleRefused, Modules
from stretch_bt.source import Map, Mark, Scalar, Seq, Value, closest, did_you_mean, is_nothing, parse, read_text
from stretch_bt.tree import registry
from stretch_bt.tree.declarations import Declarations, known_keys
from stretch_bt.tree.document import Declared, DeviceDecl, Document, Param, Signature
from stretch_bt.tree.expression import FUNCTIONS
from stretch_bt.tree.foreign.of_class import info_of
from stretch_bt.tree.foreign.refused import BehaviourRefused
from stretch_bt.tree.renamed import renamed
from stretch_bt.tree.shared import SHARED, reachable, shared_trees, shipped
from stretch_bt.tree.types import ANY, Family, Type
from stretch_bt.tree.values import Refused, check_bounds, example, literal
from stretch_bt.units import KINDS, plain_number

__all__ = ["FORMAT", "read_document"]

FORMAT = "stretch-tree/1"
MAX_FILES = 100
TOP = ("format", "doc", "imports", "devices", "scene", "tick", "params", "keys", "trees")
FRAME = ("in", "inout", "out", "keys", "doc", "guard", "finally")
#: what people write for the words of FRAME
FRAME_WORDS = {
    **dict.fromkeys(("ins", "input", "inputs"), "in"),
    **dict.fromkeys(("outs", "output", "outputs"), "out"),
    **dict.fromkeys(("key", "local", "locals"), "keys"),
}
BODY = ("sequence", "selector", "parallel", "main")


def read_document(
    path: Path,
    name: str,
    overrides: Mapping[str, Any] | None = None,
    modules: Modules | None = None,
    text: str | None = None,
) -> Document:
    """Read a tree file and all that it imports; raises FileError only when nothing of it can be read.

    `modules` says where its Python modules may stand, beside the file by default; `text` is taken for its content.
    """
    modules = modules or Modules.beside(path)
    return _Headings(path, name, dict(overrides or {}), "", (), [0], modules, text).read()


class _Headings:
    """Reads one file; every mistake is noted, none stops the reading of the rest."""

    def __init__(
        self,
        path: Path,
        name: str,
        overrides: dict[str, Any],
        prefix: str,
        stack: tuple[Path, ...],
        count: list[int],
        modules: Modules,
        text: str | None = None,
    ) -> None:
        text = read_text(path, name) if text is None else text
        root = parse(text, name)
        if not isinstance(root, Map):
            raise FileError(
                [root.mark.error("yaml-top", "the top level is not a mapping", f"begin with 'format: {FORMAT}'")]
            )
        self.doc = Document(name, path, root, prefix)
        self.doc.files[name] = hashlib.sha256(text.encode()).hexdigest()
        self.overrides = overrides
        self.stack = (*stack, path.resolve())
        self.modules = modules
        self.count = count  # of the files imported so far, by all of them together

    def error(self, mark: Mark, code: str, message: str, hint: str = "") -> None:
        self.doc.diagnostics.append(mark.error(code, message, hint))

    def read(self) -> Document:
        below = "it belongs to a tree: indent it under the tree's name"
        root = known_keys(
            self.doc.root, TOP, "a tree file", self.doc.diagnostics, dict.fromkeys((*FRAME, *BODY), below)
        )
        self.doc.root = root
        self.format(root)
        self.imports(root.get("imports"))
        self.declarations = Declarations(registry.object_types(self.doc.classes.values()), self.doc.diagnostics)
        self.doc.doc = self.declarations.text(root.get("doc"))
        self.devices(root.get("devices"))
        self.scene(root.get("scene"))
        self.params(root.get("params"))
        self.trees(root.get("trees"))
        self.shared()
        self.main_keys(root.get("keys"))
        self.tick(root.get("tick"))
        if len(self.stack) == 1:
            self.doc.hand_down(self.devices_alone() if "main" not in self.doc.trees else self.doc.devices)
        return self.doc

    def devices_alone(self) -> dict[str, DeviceDecl]:
        """Return what a library finds where it is checked by itself: one device of each kind, called as the ports of nodes are."""
        mark = self.doc.root.mark
        names = {re.sub(r"(?<=[a-z])(?=[A-Z])", "_", kind).lower(): kind for kind in INTERFACES}
        names["camera"] = names.pop("depth_camera")
        return {name: DeviceDecl(name, INTERFACES[kind], mark, used=True) for name, kind in names.items()}

    def format(self, root: Map) -> None:
        value = root.get("format")
        if value is None:
            self.error(root.mark, "format-missing", "the first key is not 'format'", f"begin with 'format: {FORMAT}'")
        elif not isinstance(value, Scalar) or value.text != FORMAT:
            given = value.text if isinstance(value, Scalar) else "this"
            self.error(value.mark, "format-unknown", f"{given!r} is not the format of a tree", f"write '{FORMAT}'")

    def entries(self, value: Value | None, what: str) -> list[tuple[Scalar, Value]]:
        if value is None or (isinstance(value, Scalar) and value.value is None):
            return []
        if not isinstance(value, Map):
            self.error(value.mark, "type-mismatch", f"{what} takes a mapping", f"write '{what}: {{name: ...}}'")
            return []
        return list(value.pairs)

    def imports(self, value: Value | None) -> None:
        for key, target in self.entries(value, "imports"):
            found = len(self.doc.diagnostics)
            if not isinstance(target, Scalar) or not target.text:
                self.error(target.mark, "import", f"{key.text} names no file or module", "write 'name: lib/file.yaml'")
            elif self.good_name(key, "import") and target.text.endswith((".yaml", ".yml")):
                self.import_trees(key, target)
            else:
                self.import_python(key, target)
            if len(self.doc.diagnostics) > found and key.text not in self.doc.imports:
                self.doc.doubtful.add(key.text)

    def import_trees(self, key: Scalar, target: Scalar) -> None:
        base = self.doc.path.parent if self.doc.path else Path()
        beside, known = base / target.text, shipped(target.text)
        path = known if known.exists() and not beside.exists() else beside
        name = target.text if path is known else str(Path(self.doc.file).parent / target.text)
        if path.resolve() in self.stack:
            self.error(target.mark, "recursion", f"{target.text} imports itself", "move what both need to a third file")
            return
        self.count[0] += 1
        if self.count[0] > MAX_FILES:
            self.error(target.mark, "import", f"more than {MAX_FILES} files are imported", "import each file once")
            return
        inner = {k.partition(".")[2]: v for k, v in self.overrides.items() if k.startswith(f"{key.text}.")}
        prefix = f"{self.doc.prefix}{key.text}."

        def read(given: dict[str, Any]) -> Document:
            return _Headings(path, name, inner | given, prefix, self.stack, self.count, self.modules).read()

        try:
            document = read({})
        except FileError as error:
            self.doc.diagnostics += error.diagnostics
            if error.diagnostics[0].code == "file-missing":
                message = f"no file {target.text!r} beside this one, nor among the shipped trees"
                self.doc.diagnostics[-1:] = [target.mark.error("import", message, _nearby(target.text, base))]
            return
        document.reread = read
        self.doc.imports[key.text] = document
        self.doc.files.update(document.files)

    def shared(self) -> None:
        """Read the shipped trees that this file calls without an import."""
        called = shared_trees(tree.body for tree in self.doc.trees.values())
        self.doc.shared_at = {name: mark for name, mark in called.items() if name not in self.doc.trees}
        for file in sorted({SHARED[name] for name in self.doc.shared_at}):
            found = _Headings(shipped(file), file, {}, "", self.stack, self.count, self.modules).read()
            wanted = reachable({name: tree.body for name, tree in found.trees.items()}, self.doc.shared_at)
            found.trees = {name: tree for name, tree in found.trees.items() if name in wanted}
            self.doc.shared |= {name: found for name in self.doc.shared_at if name in wanted}
            self.doc.files.update(found.files)

    def import_python(self, key: Scalar, target: Scalar) -> None:
        """Import a module for its nodes, or a class of behaviours, which is a node by the name of the import."""
        self.doc.modules[key.text] = target.text
        try:
            registry.load_all()  # whose names an own node may not take
            found = self.modules.bring(target.text, self.doc.path or Path("tree.yaml"))
            if isinstance(found, type) and self.good_name(key, "node"):
                self.doc.classes[key.text] = info_of(found, key.text)
        except (ModuleRefused, BehaviourRefused) as refused:
            self.error(target.mark, "import", str(refused), refused.hint)

    def devices(self, value: Value | None) -> None:
        self.doc.declares_devices = value is not None
        for key, kind in self.entries(value, "devices"):
            interface = INTERFACES.get(kind.text) if isinstance(kind, Scalar) else None
            if interface is None:
                given = kind.text if isinstance(kind, Scalar) else "this"
                self.doc.doubtful.add(key.text)
                hint = did_you_mean(given, INTERFACES)
                self.error(kind.mark, "device-type", f"{given!r} is not a kind of device", hint)
            elif self.good_name(key, "device"):
                self.doc.devices[key.text] = DeviceDecl(key.text, interface, key.mark)

    def good_name(self, key: Scalar, what: str) -> bool:
        reserved: tuple[str, ...] = ("params", "task", "none", "true", "false", "and", "or", "not")
        reserved += tuple(FUNCTIONS) if what in ("parameter", "key") else ()
        if re.fullmatch(r"[A-Za-z_]\w*", key.text, re.ASCII) and key.text not in reserved:
            return True
        self.error(
            key.mark,
            "name",
            f"{key.text!r} cannot be the name of a {what}",
            "use letters a to z, digits and _, no reserved word",
        )
        return False

    def scene(self, value: Value | None) -> None:
        if isinstance(value, Scalar) and value.text:
            self.doc.scene = value
        elif value is not None:
            self.error(
                value.mark, "type-mismatch", "scene takes the name or path of a scene", "write 'scene: water_balloon'"
            )

    def tick(self, value: Value | None) -> None:
        if value is None:
            return
        type_ = Type("Time", Family.QUANTITY, KINDS["Time"].dimension)
        try:
            self.doc.tick_period = literal(value, type_, "tick")
            check_bounds(self.doc.tick_period, type_, 0.001, 10.0, value.mark, "tick")
        except Refused as refused:
            self.doc.diagnostics.append(refused.diagnostic)

    def params(self, value: Value | None) -> None:
        for key, spec in self.entries(value, "params"):
            if not self.good_name(key, "parameter"):
                continue
            declared = self.declarations.read(key, spec, "parameter")
            self.doc.params[key.text] = Param(
                **{f: getattr(declared, f) for f in Declared.__slots__}, value=declared.default
            )
        self.override()
        for param in self.doc.params.values():
            if param.value is None and not param.has_default and param.type is not ANY:
                hint = f"give it a default, or --set {self.doc.prefix}{param.name}=..."
                self.error(param.mark, "param-missing", f"parameter {param.name!r} has no value", hint)

    def override(self) -> None:
        for name, given in self.overrides.items():
            prefix, _, rest = name.partition(".")
            if rest and prefix in self.doc.imports:
                continue
            text: Any = given.text if isinstance(given, Scalar) else given
            mark = Mark("--set", 1, len(self.doc.prefix) + len(name) + 2, len(str(text)) or 1)
            if isinstance(given, Scalar):  # of a scene
                mark = given.mark
            param = self.doc.params.get(name)
            if param is None:
                at = Mark("--set", 1, 1, len(name))
                known = [*self.doc.params, *(f"{p}.{n}" for p, d in self.doc.imports.items() for n in d.params)]
                now = renamed(Path(self.doc.file).stem, name)
                hint = f"it is called {now!r} now: write '--set {now}=...'" if now else did_you_mean(name, known)
                self.error(at, "param-unknown", f"there is no parameter {name!r}", hint)
                continue
            try:
                param.value = literal(_given(text, param.type, mark), param.type, name)
                check_bounds(param.value, param.type, param.min, param.max, mark, name)
            except Refused as refused:
                self.doc.diagnostics.append(refused.diagnostic)
            except FileError:
                self.error(mark, "type-mismatch", f"{name} takes {param.type}, not {text!r}", example(param.type))

    def trees(self, value: Value | None) -> None:
        entries = self.entries(value, "trees")
        if not entries and (value is None or isinstance(value, Map) or value.plain() is None):
            mark = value.mark if value is not None else self.doc.root.mark
            self.error(mark, "trees-missing", "the file has no trees", "add 'trees: {main: ...}'")
        for key, body in entries:
            if not self.good_name(key, "tree"):
                continue
            self.doc.trees[key.text] = self.signature(key, _as_body(body))

    def frame(self, body: Map) -> Map:
        """Put right what stands for `in`, `out` and `keys` in other languages, and note it."""
        pairs = []
        for key, value in body:
            word = FRAME_WORDS.get(key.text, "")
            if word and word not in body and isinstance(value, Map):
                self.error(key.mark, "key-unknown", f"a tree has no {key.text!r}", f"did you mean {word!r}?")
                key = Scalar(word, False, key.mark)
            pairs.append((key, value))
        return Map(tuple(pairs), body.mark)

    def signature(self, key: Scalar, body: Map) -> Signature:
        body = self.frame(body)
        inner = Map(
            tuple((k, v) for k, v in body.pairs if k.text not in ("in", "inout", "out", "keys", "doc")), body.mark
        )
        found = Signature(key.text, key.mark, self.doc, inner, doc=self.declarations.text(body.get("doc")))
        tables = {"in": found.ins, "inout": found.inouts, "out": found.outs, "keys": found.keys}
        for field, table in tables.items():
            for name, spec in self.border(body.get(field), field):
                self.add_key(found, table, name, spec)
        for word in ("in", "inout") if found.name == "main" and not self.doc.prefix else ():
            if word in body:
                at, hint = body.key(word).mark, "make it a parameter, under 'params:', or a key"
                self.error(at, "key-unknown", f"'main' is called by nobody, so it has no {word!r}", hint)
        return found

    def border(self, value: Value | None, what: str) -> list[tuple[Scalar, Value]]:
        """Return names with their declarations, which a list of names leaves empty."""
        if not isinstance(value, Seq) or what == "keys":
            return self.entries(value, what)
        found: list[tuple[Scalar, Value]] = []
        for item in value.items:
            if isinstance(item, Scalar):
                found.append((item, Scalar("", False, item.mark)))
            else:
                self.error(
                    item.mark, "type-mismatch", f"{what} takes a list of names", f"write '{what}: [depth, stretch]'"
                )
        return found

    def main_keys(self, value: Value | None) -> None:
        main = self.doc.trees.get("main")
        entries = self.entries(value, "keys")
        if main is None:
            if entries:
                self.error(
                    entries[0][0].mark,
                    "key-unused",
                    "keys at the top belong to 'main', which is not here",
                    "move them to a tree",
                )
            return
        for name, spec in entries:
            self.add_key(main, main.keys, name, spec)

    def add_key(self, tree: Signature, table: dict[str, Declared], name: Scalar, spec: Value) -> None:
        if not self.good_name(name, "key"):
            return
        first = tree.declared(name.text)
        if first is not None:
            self.error(
                name.mark,
                "key-duplicate",
                f"${name.text} is declared twice (first on line {first.mark.line})",
                "keep one",
            )
        elif name.text in self.doc.devices:
            self.error(name.mark, "key-duplicate", f"${name.text} has the name of a device", "rename one of them")
        else:
            more = ("scene",) if table is tree.outs and tree.name == "main" else ()
            declared = self.declarations.read(name, spec, "key", more)
            declared.listed = table in (tree.ins, tree.inouts) and is_nothing(spec)
            table[name.text] = declared


def _nearby(target: str, base: Path) -> str:
    """Return a hint with the file that the name of an import resembles."""
    folder = (base / target).parent
    present = [str(Path(target).parent / p.name) for p in islice(folder.glob("*.y*ml"), 100)]
    known = [str(p.relative_to(shipped(""))) for p in islice(shipped("lib").glob("*.yaml"), 100)]
    guess = closest(target, [*present, *known])
    return f"did you mean {guess!r}?" if guess else "check the path, which is relative to this file"


def _given(text: Any, type_: Type, mark: Mark) -> Value:
    """Return an override as a value of a file; only a list is written in YAML."""
    written = _written(text, type_)
    if type_.family is Family.LIST:
        return _moved(parse(written, "--set"), mark)
    return Scalar(written, type_.family in (Family.STR, Family.ENUM), mark)


def _written(value: Any, type_: Type) -> str:
    """Return an override as a file would have it; numbers given from Python are SI."""
    value = plain_number(value)
    if isinstance(value, str):
        return value
    if isinstance(value, list | tuple):
        return f"[{', '.join(_written(item, type_.item or type_) for item in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value!r} {type_.kind.si_unit}" if type_.kind else str(value)


def _as_body(value: Value) -> Map:
    """Return a tree's body as a mapping; a list is a sequence, and a bare name a node, as everywhere."""
    if isinstance(value, Map):
        return value
    if isinstance(value, Seq):
        return Map(((Scalar("sequence", False, value.mark), value),), value.mark)
    if value.value is None:
        return Map((), value.mark)
    return Map(((value, Scalar("", False, value.mark)),), value.mark)


def _moved(value: Value, mark: Mark) -> Value:
    """Return a value of the command line with its place there."""
    if isinstance(value, Scalar):
        return Scalar(value.text, value.quoted, mark)
    if isinstance(value, Map):
        return Map(value.pairs, mark)
    return type(value)(tuple(_moved(item, mark) for item in value.items), mark)
