"""Reading the headings of a tree file: imports, params, devices, keys and the borders of its trees."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from stretch_bt.errors import FileError
from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.source import Map, Mark, Scalar, Value, did_you_mean, parse, read_text
from stretch_bt.tree import registry
from stretch_bt.tree.document import Declared, DeviceDecl, Document, Param, Signature
from stretch_bt.tree.types import Family, Type, named
from stretch_bt.tree.values import Refused, check_bounds, literal
from stretch_bt.units import KINDS, parse_unit

__all__ = ["FORMAT", "read_document"]

FORMAT = "stretch-tree/1"
TOP = ("format", "doc", "imports", "devices", "scene", "tick", "params", "keys", "trees")
FRAME = ("in", "out", "keys", "doc", "guard", "finally")


def shipped(name: str) -> Path:
    """Return the path of a file among the shipped trees."""
    return Path(str(files("stretch_bt") / "trees" / name))


def read_document(path: Path, name: str, overrides: Mapping[str, Any] | None = None) -> Document:
    """Read a tree file and all that it imports; raises FileError only when nothing of it can be read."""
    return _Headings(path, name, dict(overrides or {}), "", ()).read()


class _Headings:
    """Reads one file; every mistake is noted, none stops the reading of the rest."""

    def __init__(self, path: Path, name: str, overrides: dict[str, Any], prefix: str, stack: tuple[Path, ...]) -> None:
        text = read_text(path, name)
        root = parse(text, name)
        if not isinstance(root, Map):
            raise FileError(
                [root.mark.error("yaml-top", "the top level is not a mapping", f"begin with 'format: {FORMAT}'")]
            )
        self.doc = Document(name, path, root, prefix)
        self.doc.files[name] = hashlib.sha256(text.encode()).hexdigest()
        self.overrides = overrides
        self.stack = (*stack, path.resolve())

    def error(self, mark: Mark, code: str, message: str, hint: str = "") -> None:
        self.doc.diagnostics.append(mark.error(code, message, hint))

    def read(self) -> Document:
        root = self.doc.root
        self.known_keys(root, TOP, "a tree file")
        self.format(root)
        self.doc.doc = self.text(root.get("doc"))
        self.imports(root.get("imports"))
        self.objects = registry.object_types()
        self.devices(root.get("devices"))
        self.scene(root.get("scene"))
        self.params(root.get("params"))
        self.trees(root.get("trees"))
        self.main_keys(root.get("keys"))
        self.tick(root.get("tick"))
        return self.doc

    def known_keys(self, value: Map, known: tuple[str, ...], what: str) -> None:
        for key, _ in value:
            if key.text not in known:
                self.error(key.mark, "key-unknown", f"{what} has no {key.text!r}", did_you_mean(key.text, known))

    def format(self, root: Map) -> None:
        value = root.get("format")
        if value is None:
            self.error(root.mark, "format-missing", "the first key is not 'format'", f"begin with 'format: {FORMAT}'")
        elif not isinstance(value, Scalar) or value.text != FORMAT:
            given = value.text if isinstance(value, Scalar) else "this"
            self.error(
                value.mark, "format-unknown", f"{given!r} is not the format of a tree", f"write 'format: {FORMAT}'"
            )

    def text(self, value: Value | None) -> str:
        if value is None:
            return ""
        if not isinstance(value, Scalar):
            self.error(value.mark, "type-mismatch", "doc takes text", "write one sentence")
            return ""
        return " ".join(value.text.split())

    def entries(self, value: Value | None, what: str) -> list[tuple[Scalar, Value]]:
        if value is None or (isinstance(value, Scalar) and value.value is None):
            return []
        if not isinstance(value, Map):
            self.error(value.mark, "type-mismatch", f"{what} takes a mapping", f"write '{what}: {{name: ...}}'")
            return []
        return list(value.pairs)

    def imports(self, value: Value | None) -> None:
        for key, target in self.entries(value, "imports"):
            if not isinstance(target, Scalar) or not target.text:
                self.error(target.mark, "import", f"{key.text} names no file or module", "write 'name: lib/file.yaml'")
            elif target.text.endswith((".yaml", ".yml")):
                self.import_trees(key, target)
            else:
                self.import_module(target)

    def import_trees(self, key: Scalar, target: Scalar) -> None:
        base = self.doc.path.parent if self.doc.path else Path()
        path = next((p for p in (base / target.text, shipped(target.text)) if p.exists()), base / target.text)
        if path.resolve() in self.stack:
            self.error(target.mark, "recursion", f"{target.text} imports itself", "move what both need to a third file")
            return
        name = (
            str(Path(self.doc.file).parent / target.text) if path.parent == (base / target.text).parent else target.text
        )
        inner = {k.partition(".")[2]: v for k, v in self.overrides.items() if k.startswith(f"{key.text}.")}
        try:
            document = _Headings(path, name, inner, f"{self.doc.prefix}{key.text}.", self.stack).read()
        except FileError as error:
            missing = error.diagnostics[0].code == "file-missing"
            self.doc.diagnostics += (
                [
                    target.mark.error(
                        "import",
                        f"no file {target.text!r} beside this one, nor among the shipped trees",
                        "check the path",
                    )
                ]
                if missing
                else error.diagnostics
            )
            return
        self.doc.imports[key.text] = document
        self.doc.files.update(document.files)

    def import_module(self, target: Scalar) -> None:
        folder = str(self.doc.path.parent.resolve()) if self.doc.path else "."
        added = folder not in sys.path
        if added:
            sys.path.insert(0, folder)
        try:
            registry.import_nodes(target.text)
        except Exception as error:
            hint = "install the package, or check the module's name"
            self.error(
                target.mark,
                "import",
                f"module {target.text!r} cannot be imported: {type(error).__name__}: {error}",
                hint,
            )
        finally:
            if added:
                sys.path.remove(folder)

    def devices(self, value: Value | None) -> None:
        for key, kind in self.entries(value, "devices"):
            interface = INTERFACES.get(kind.text) if isinstance(kind, Scalar) else None
            if interface is None:
                given = kind.text if isinstance(kind, Scalar) else "this"
                self.error(
                    kind.mark, "device-type", f"{given!r} is not a kind of device", did_you_mean(given, INTERFACES)
                )
            elif self.good_name(key, "device"):
                self.doc.devices[key.text] = DeviceDecl(key.text, interface, key.mark)

    def good_name(self, key: Scalar, what: str) -> bool:
        reserved = ("params", "task", "true", "false", "and", "or", "not")
        if key.text.isidentifier() and key.text not in reserved:
            return True
        self.error(
            key.mark,
            "name",
            f"{key.text!r} cannot be the name of a {what}",
            "use letters, digits and _, no reserved word",
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
            declared = self.declared(key, spec, "parameter")
            if declared is not None:
                param = Param(**{f: getattr(declared, f) for f in Declared.__slots__}, value=declared.default)
                self.doc.params[key.text] = param
        self.override()
        for param in self.doc.params.values():
            if param.value is None and not param.has_default:
                hint = f"give it a default, or --set {self.doc.prefix}{param.name}=..."
                self.error(param.mark, "param-missing", f"parameter {param.name!r} has no value", hint)

    def override(self) -> None:
        for name, text in self.overrides.items():
            prefix, _, rest = name.partition(".")
            if rest and prefix in self.doc.imports:
                continue
            mark = Mark("--set", 1, len(self.doc.prefix) + len(name) + 2, len(str(text)) or 1)
            param = self.doc.params.get(name)
            if param is None:
                at = Mark("--set", 1, 1, len(name))
                known = [*self.doc.params, *(f"{p}.{n}" for p, d in self.doc.imports.items() for n in d.params)]
                self.error(at, "param-unknown", f"there is no parameter {name!r}", did_you_mean(name, known))
                continue
            try:
                value = _moved(parse(_written(text, param.type), "--set"), mark)
                param.value = literal(value, param.type, name)
                check_bounds(param.value, param.type, param.min, param.max, mark, name)
            except Refused as refused:
                self.doc.diagnostics.append(refused.diagnostic)
            except FileError:
                self.error(
                    mark, "type-mismatch", f"{name} takes {param.type}, not {text!r}", f"write --set {name}=VALUE"
                )

    def declared(self, key: Scalar, spec: Value, what: str) -> Declared | None:
        """Read `name: Type` or `name: {type, default, min, max, unit, doc}`."""
        fields = ("type", "default", "min", "max", "unit", "doc")
        if isinstance(spec, Map):
            self.known_keys(spec, fields, f"a {what}")
            type_value = spec.get("type")
        else:
            type_value, spec = spec, Map((), spec.mark)
        if not isinstance(type_value, Scalar):
            self.error(
                key.mark, "type-missing", f"{what} {key.text!r} has no type", "write 'type: Length', or another type"
            )
            return None
        type_ = named(type_value.text, self.objects)
        if type_ is None:
            known = [*KINDS, "int", "float", "bool", "str", *self.objects]
            self.error(
                type_value.mark, "type-unknown", f"no type {type_value.text!r}", did_you_mean(type_value.text, known)
            )
            return None
        found = Declared(key.text, type_, key.mark, doc=self.text(spec.get("doc")))
        try:
            self.options(found, spec)
        except Refused as refused:
            self.doc.diagnostics.append(refused.diagnostic)
        return found

    def options(self, found: Declared, spec: Map) -> None:
        bound_type = found.type.item or found.type
        for name in ("min", "max"):
            value = spec.get(name)
            if value is not None:
                setattr(found, name, literal(value, bound_type, name))
        default = spec.get("default")
        if default is not None:
            found.default, found.has_default = literal(default, found.type, found.name), True
            check_bounds(found.default, found.type, found.min, found.max, default.mark, found.name)
        unit = spec.get("unit")
        if isinstance(unit, Scalar):
            found.unit = self.unit(unit, found.type)

    def unit(self, value: Scalar, type_: Type) -> str | None:
        try:
            if parse_unit(value.text)[1] == type_.dimension:
                return value.text
        except ValueError:
            pass
        unit = type_.kind.unit if type_.kind else "none"
        self.error(
            value.mark, "unit-mismatch", f"{value.text!r} is not a unit of {type_}", f"write '{unit}', or leave it out"
        )
        return None

    def trees(self, value: Value | None) -> None:
        if value is None:
            self.error(self.doc.root.mark, "trees-missing", "the file has no trees", "add 'trees: {main: ...}'")
        for key, body in self.entries(value, "trees"):
            if not self.good_name(key, "tree"):
                continue
            if not isinstance(body, Map):
                self.error(
                    body.mark, "type-mismatch", f"tree {key.text!r} has no body", "write 'sequence: [...]' under it"
                )
                continue
            self.doc.trees[key.text] = self.signature(key, body)

    def signature(self, key: Scalar, body: Map) -> Signature:
        inner = Map(tuple((k, v) for k, v in body.pairs if k.text not in ("in", "out", "keys", "doc")), body.mark)
        found = Signature(key.text, key.mark, self.doc, inner, doc=self.text(body.get("doc")))
        for field, table in (("in", found.ins), ("out", found.outs), ("keys", found.keys)):
            for name, spec in self.entries(body.get(field), field):
                self.add_key(found, table, name, spec)
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
            declared = self.declared(name, spec, "key")
            if declared is not None:
                table[name.text] = declared


def _written(value: Any, type_: Type) -> str:
    """Return an override as a file would have it; numbers given from Python are SI."""
    if isinstance(value, str):
        return value
    if isinstance(value, list | tuple):
        return f"[{', '.join(_written(item, type_.item or type_) for item in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value!r} {type_.kind.si_unit}" if type_.kind else str(value)


def _moved(value: Value, mark: Mark) -> Value:
    """Return a value of the command line with its place there."""
    if isinstance(value, Scalar):
        return Scalar(value.text, value.quoted, mark)
    if isinstance(value, Map):
        return Map(value.pairs, mark)
    return type(value)(tuple(_moved(item, mark) for item in value.items), mark)
