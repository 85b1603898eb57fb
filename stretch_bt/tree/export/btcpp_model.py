"""The TreeNodesModel of BehaviorTree.CPP: what an editor must know of nodes that are not its own."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.document import Signature
from stretch_bt.tree.export.escape import clean
from stretch_bt.tree.flow import Part
from stretch_bt.tree.flow.guard import Check
from stretch_bt.tree.flow.parallel import Parallel
from stretch_bt.tree.port import Role
from stretch_bt.tree.registry import NodeInfo
from stretch_bt.tree.schema.nodes import as_text

__all__ = ["Model", "model_name", "port_name"]

FINALLY = "with_finally"


def model_name(name: str) -> str:
    """Return the name of a tree as that format allows it: without a dot."""
    return name.replace(".", "-")


def port_name(name: str) -> str:
    """Return the name of a port, moved away from the attributes that the format keeps for itself."""
    return f"{name}_" if name in ("ID", "name") or name.startswith("_") else name


class Model:
    """Collects the nodes that a file uses, each once."""

    def __init__(self) -> None:
        self._entries: dict[str, ET.Element] = {}

    def element(self) -> ET.Element:
        """Return the model, in the order of the alphabet."""
        model = ET.Element("TreeNodesModel")
        model.extend(self._entries[name] for name in sorted(self._entries))
        return model

    def leaf(self, info: NodeInfo) -> str:
        """Add a node of the registry; return its category."""
        tag = "Condition" if info.cls.kind == "condition" and info.instant else "Action"
        entry = self._entry(tag, info.name)
        if entry is None:
            return tag
        for port in info.ports.values():
            if port.role is Role.OUTPUT:
                continue
            type_ = info.types[port.name]
            if port.role is Role.INOUT:
                _port(entry, "inout_port", port.name, type_.name, port.doc)
                continue
            default = None if port.default in (MISSING, None) else as_text(port.default, type_)
            _port(entry, "input_port", port.name, type_.name, port.doc, default)
        for name, type_ in info.outputs.items():
            declared = info.ports.get(name)
            doc = declared.doc if declared else f"standard deviation of {name.removesuffix('_sd')}"
            _port(entry, "output_port", name, type_.name, doc)
        return tag

    def construct(self, part: Part) -> tuple[str, dict[str, str]]:
        """Add a construct without counterpart; return its category and attributes."""
        settings = part.written()
        if part.keyword == "set":
            settings = {"assign": "; ".join(f"{key} := {text}" for key, text in settings.items())}
        tag = "Condition" if isinstance(part, Check) else "Action"
        if part.children():
            tag = "Control" if isinstance(part, Parallel) else "Decorator"
        entry = self._entry(tag, part.keyword)
        for name in settings if entry is not None else ():
            _port(entry, "input_port", name, "std::string", "")
        return tag, {"ID": part.keyword, **{port_name(name): text for name, text in settings.items()}}

    def finally_(self) -> str:
        """Add the node whose second child runs at the end, however the first ended; return its name."""
        self._entry("Control", FINALLY)
        return FINALLY

    def subtree(self, signature: Signature) -> None:
        """Add a tree with what crosses its border."""
        entry = self._entry("SubTree", model_name(signature.qualified))
        for tag, table in (
            ("input_port", signature.ins),
            ("inout_port", signature.inouts),
            ("output_port", signature.outs),
        ):
            for declared in table.values() if entry is not None else ():
                default = as_text(declared.default, declared.type) if declared.has_default else None
                _port(entry, tag, declared.name, declared.type.name, declared.doc, default)
        for name, declared in signature.deviations.items() if entry is not None else ():
            _port(entry, "output_port", name, declared.type.name, f"standard deviation of {declared.name}", None)

    def _entry(self, tag: str, name: str) -> ET.Element | None:
        """Return a new entry, or None when there is one of this name."""
        if name in self._entries:
            return None
        self._entries[name] = ET.Element(tag, ID=name)
        return self._entries[name]


def _port(entry: ET.Element | None, tag: str, name: str, type_: str, doc: str, default: str | None = None) -> None:
    assert entry is not None
    port = ET.SubElement(entry, tag, name=port_name(name), type=type_)
    if default is not None:
        port.set("default", clean(default))
    port.text = clean(doc) or None
