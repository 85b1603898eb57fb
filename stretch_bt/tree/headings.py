"""Reading the headings of a tree file: imports, params, devices, keys and the borders of its trees."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from stretch_bt.errors import FileError
from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.hardware.own_modules import Modules
from stretch_bt.source import FILE_KINDS, Map, Scalar, Value, did_you_mean, parse, read_text, told
from stretch_bt.tree import registry
from stretch_bt.tree.borders import FRAME, Borders
from stretch_bt.tree.declarations import Declarations, known_keys
from stretch_bt.tree.document import Declared, DeviceDecl, Document, Param
from stretch_bt.tree.heading_reader import HeadingReader
from stretch_bt.tree.imports import Imports
from stretch_bt.tree.param_values import set_params
from stretch_bt.tree.types import Family, Type
from stretch_bt.tree.values import ValueRefused, check_bounds, literal, refuse
from stretch_bt.units import KINDS

__all__ = ["FORMAT", "read_document"]

FORMAT = "stretch-tree/1"
#: who takes files of other kinds, by how their formats begin
OTHERS = {
    "stretch-scene": "--scene of `stretch-bt run TREE`",
    "stretch-cell": "--cell of `stretch-bt run TREE`",
    "stretch-mocks": "--mocks of `stretch-bt run TREE`",
    "stretch-sweep": "`stretch-bt sweep`",
}
TOP = ("format", "doc", "imports", "devices", "scene", "tick", "params", "keys", "trees")
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


class _Headings(HeadingReader):
    """Reads one file."""

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
        _check_kind(root)
        super().__init__(Document(name, path, root, prefix))
        self.doc.files[name] = hashlib.sha256(text.encode()).hexdigest()
        self.overrides = overrides
        self.stack = (*stack, path.resolve())
        self.modules = modules
        self.count = count  # of the files imported so far, by all of them together

    def read(self) -> Document:
        below = "it belongs to a tree: indent it under the tree's name"
        root = known_keys(
            self.doc.root, TOP, "a tree file", self.doc.diagnostics, dict.fromkeys((*FRAME, *BODY), below)
        )
        self.doc.root = root
        self.format(root)
        imports = Imports(self.doc, self.overrides, self.stack, self.count, self.modules, self.other_file)
        imports.read(root.get("imports"))
        self.declarations = Declarations(
            partial(registry.object_types, self.doc.classes.values()), self.doc.diagnostics
        )
        self.doc.doc = self.declarations.text(root.get("doc"))
        self.devices(root.get("devices"))
        self.scene(root.get("scene"))
        self.params(root.get("params"))
        borders = Borders(self.doc, self.declarations)
        borders.read(root.get("trees"))
        imports.shared()
        borders.main_keys(root.get("keys"))
        self.tick(root.get("tick"))
        if len(self.stack) == 1:
            devices = self.devices_alone() if "main" not in self.doc.trees else self.doc.devices
            self.doc.hand_down(devices, self.doc.doubtful_devices)
        return self.doc

    def other_file(self, path: Path, name: str, overrides: dict[str, Any], prefix: str) -> Document:
        return _Headings(path, name, overrides, prefix, self.stack, self.count, self.modules).read()

    def devices_alone(self) -> dict[str, DeviceDecl]:
        """Return the devices of a library that is checked by itself: one device of each kind, called as the ports of nodes are."""
        mark = self.doc.root.mark
        names = {re.sub(r"(?<=[a-z])(?=[A-Z])", "_", kind).lower(): kind for kind in INTERFACES}
        names["camera"] = names.pop("depth_camera")
        return {name: DeviceDecl(name, INTERFACES[kind], mark, used=True) for name, kind in names.items()}

    def format(self, root: Map) -> None:
        value = root.get("format")
        if value is None:
            self.error(root.mark, "format-missing", "the file has no 'format'", f"begin with 'format: {FORMAT}'")
        elif not isinstance(value, Scalar) or value.text != FORMAT:
            what = f"{told(value)} is not the format of a tree"
            self.error(value.mark, "format-unknown", what, f"write 'format: {FORMAT}'")

    def devices(self, value: Value | None) -> None:
        self.doc.declares_devices = value is not None
        for key, kind in self.entries(value, "devices"):
            interface = INTERFACES.get(kind.text) if isinstance(kind, Scalar) else None
            if interface is None:
                self.doc.doubtful.add(key.text)
                self.doc.doubtful_devices.add(key.text)
                hint = did_you_mean(kind.text if isinstance(kind, Scalar) else "", INTERFACES)
                self.error(kind.mark, "device-type", f"{told(kind)} is not a kind of device", hint)
            elif self.good_name(key, "device"):
                self.doc.devices[key.text] = DeviceDecl(key.text, interface, key.mark)

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
            if isinstance(value, Scalar) and isinstance(value.value, int | float) and not isinstance(value.value, bool):
                refuse(value.mark, "unit-missing", f"tick: {value.text} has no unit", f"write '{value.text} ms'")
            self.doc.tick_period = literal(value, type_, "tick")
            check_bounds(self.doc.tick_period, type_, 0.001, 10.0, value.mark, "tick")
        except ValueRefused as refused:
            self.doc.diagnostics.append(refused.diagnostic)

    def params(self, value: Value | None) -> None:
        for key, spec in self.entries(value, "params"):
            if not self.good_name(key, "param"):
                continue
            declared = self.declarations.read(key, spec, "param")
            self.doc.params[key.text] = Param(
                **{f: getattr(declared, f) for f in Declared.__slots__}, value=declared.default
            )
        set_params(self.doc, self.overrides)


def _check_kind(root: Map) -> None:
    """Refuse a file of another kind by that alone: none of its keys is one of a tree."""
    value = root.get("format")
    kind = value.text.partition("/")[0] if isinstance(value, Scalar) else ""
    if isinstance(value, Scalar) and kind in OTHERS:
        hint = f"begin a tree with 'format: {FORMAT}', and give this to {OTHERS[kind]}"
        raise FileError([value.mark.error("format-unknown", f"this is a {FILE_KINDS[kind]}, not a tree", hint)])
