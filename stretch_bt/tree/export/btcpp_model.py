"""The TreeNodesModel of BehaviorTree.CPP: what an editor must know of nodes that are not its own."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Collection, Hashable, Mapping
from itertools import count

from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.document import Signature
from stretch_bt.tree.export.escape import clean
from stretch_bt.tree.flow import Call, Part
from stretch_bt.tree.flow.guard import Check
from stretch_bt.tree.flow.parallel import Parallel
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.port import Role
from stretch_bt.tree.schema.nodes import as_text
from stretch_bt.tree.values import written_pairs

__all__ = ["Model", "entry_of", "port_name"]

FINALLY, KEYS = "with_finally", "with_keys"


def port_name(name: str) -> str:
    """Return the name of a port, moved away from the attributes that the format keeps for itself."""
    return f"{name}_" if name in ("ID", "name") or name.startswith("_") else name


def entry_of(key: str) -> str:
    """Return how an attribute names the Blackboard's entry for a key, which is that of the port where it crosses the border."""
    return f"{{{port_name(key)}}}"


class Model:
    """Collects the nodes and trees that a file uses, each once and each with an ID of its own.

    `handed` holds, by the id of a tree's signature, the devices that calls hand to it: they are ports of that tree.
    """

    def __init__(self, handed: Mapping[int, Collection[str]]) -> None:
        self._entries: dict[str, ET.Element] = {}
        self._ids: dict[Hashable, str] = {}
        self._handed = handed

    def element(self) -> ET.Element:
        """Return the model, in the order of the alphabet."""
        model = ET.Element("TreeNodesModel")
        model.extend(self._entries[name] for name in sorted(self._entries))
        return model

    def tree_name(self, signature: Signature) -> str:
        """Return the ID of a tree; calls with other params are calls of other trees."""
        return self._id(id(signature), signature.qualified)

    def device(self, within: Signature, name: str) -> str:
        """Return how a tree writes one of its devices: by name, or as the port by which its callers hand it on."""
        return entry_of(name) if name in self._handed[id(within)] else name

    def devices_of_call(self, within: Signature, call: Call) -> dict[str, str]:
        """Return the devices that a call in the tree `within` hands on, by port."""
        found = {}
        for name in sorted(self._handed[id(call.target)]):
            given = self.device(within, call.devices.get(name, name))
            if given != name:  # else it is the default
                found[port_name(name)] = given
        return found

    def leaf(self, info: NodeInfo) -> tuple[str, str]:
        """Add a node of the registry; return its category and its ID."""
        tag = "Condition" if info.cls.kind == "condition" and info.instant else "Action"
        known = self._id((info.name, info.cls), info.name)
        entry = self._entry(tag, known)
        if entry is None:
            return tag, known
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
        return tag, known

    def construct(self, part: Part) -> tuple[str, dict[str, str]]:
        """Add a construct without counterpart; return its category and attributes."""
        settings = part.written()
        if part.keyword == "set":
            settings = {"assign": "; ".join(f"{key} := {text}" for key, text in settings.items())}
        tag = "Condition" if isinstance(part, Check) else "Action"
        if part.children():
            tag = "Control" if isinstance(part, Parallel) else "Decorator"
        self._entry(tag, part.keyword)
        entry = self._entries[part.keyword]
        declared = {port.get("name") for port in entry}
        for name in settings:  # each use may write others
            if port_name(name) not in declared:
                _port(entry, "input_port", name, "std::string", "")
        return tag, {"ID": part.keyword, **{port_name(name): text for name, text in settings.items()}}

    def finally_(self) -> str:
        """Add the node whose second child runs at the end, however the first ended; return its ID."""
        known = self._id(FINALLY, FINALLY)
        self._entry("Control", known)
        return known

    def keys(self, own: Mapping[str, str]) -> dict[str, str]:
        """Add the node that begins a tree with keys of its own; return its attributes, given the declarations as written."""
        known = self._id(KEYS, KEYS)
        entry = self._entry("Decorator", known)
        if entry is not None:
            _port(entry, "input_port", "keys", "std::string", "")
        return {"ID": known, "keys": written_pairs(own)}

    def subtree(self, signature: Signature) -> None:
        """Add a tree, which comes once, with what crosses its border and the devices that calls hand to it."""
        entry = self._entry("SubTree", self.tree_name(signature))
        for name in sorted(self._handed[id(signature)]):
            kind = signature.document.devices[name].interface.__name__
            _port(entry, "input_port", name, kind, "", name)
        for tag, table in (
            ("input_port", signature.ins),
            ("inout_port", signature.inouts),
            ("output_port", signature.outs),
        ):
            for declared in table.values():
                default = as_text(declared.default, declared.type) if declared.has_default else None
                _port(entry, tag, declared.name, declared.type.name, declared.doc, default)
        for name, declared in signature.deviations.items():
            _port(entry, "output_port", name, declared.type.name, f"standard deviation of {declared.name}", None)

    def _id(self, thing: Hashable, name: str) -> str:
        """Return the ID of a thing: its name without a dot, which the format does not allow, and with a number where it is taken."""
        if thing not in self._ids:
            free = name = name.replace(".", "-")
            numbers = count(2)
            while free in self._ids.values():
                free = f"{name}-{next(numbers)}"
            self._ids[thing] = free
        return self._ids[thing]

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
