"""XML of BehaviorTree.CPP 4, which Groot2 opens.

What has a counterpart there becomes it; the rest stands as custom nodes, described in the TreeNodesModel. Quantities and
expressions stay text as the file has them; `$key` becomes `{key}`, and a param the value that a run takes.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence

from stretch_bt.tree.document import Signature
from stretch_bt.tree.export.btcpp_model import Model, entry_of, port_name
from stretch_bt.tree.export.escape import clean
from stretch_bt.tree.flow import Call, Leaf, Part, Wire
from stretch_bt.tree.flow.parallel import Parallel
from stretch_bt.tree.flow.repeat import Repeat, Retry
from stretch_bt.tree.flow.timeout import Timeout
from stretch_bt.tree.program import Program, TreeBody
from stretch_bt.tree.schema.nodes import as_text
from stretch_bt.tree.types import Type

__all__ = ["write"]

_SAME = {
    "sequence": "Sequence",
    "reactive_sequence": "ReactiveSequence",
    "selector": "Fallback",
    "reactive_selector": "ReactiveFallback",
    "invert": "Inverter",
    "force_success": "ForceSuccess",
    "force_failure": "ForceFailure",
}
_POLICIES = {"success_on_all": "-1", "success_on_one": "1"}


def write(program: Program) -> str:
    """Return the file: every tree that `main` reaches, or all of a file without `main`."""
    bodies = list(_bodies(program))
    model = Model(_handed(bodies))
    root = ET.Element("root", BTCPP_format="4")
    if "main" in program.document.trees:
        root.set("main_tree_to_execute", model.tree_name(program.document.trees["main"]))
    for body in bodies:
        tree = ET.SubElement(root, "BehaviorTree", ID=model.tree_name(body.signature))
        parent = tree
        if body.signature.own:
            parent = ET.SubElement(
                parent, "Decorator", {n: clean(t) for n, t in model.keys(body.signature.own).items()}
            )
        if body.finish is not None:
            parent = ET.SubElement(parent, "Control", ID=model.finally_())
        _add(parent, body.part, body.signature, model)
        if body.finish is not None:
            _add(parent, body.finish, body.signature, model)
        model.subtree(body.signature)
    root.append(model.element())
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _bodies(program: Program) -> Iterator[TreeBody]:
    trees = program.document.trees
    waiting: list[Signature] = [trees["main"]] if "main" in trees else list(trees.values())
    seen: set[int] = set()
    for signature in waiting:  # grows while it is worked through
        if id(signature) not in seen:
            seen.add(id(signature))
            body = program.body(signature)
            waiting += [call.target for call in body.calls()]
            yield body


def _handed(bodies: Sequence[TreeBody]) -> dict[int, set[str]]:
    """Return, by the id of a tree's signature, the devices that its callers hand on, directly or from their own callers."""
    found: dict[int, set[str]] = {id(body.signature): set() for body in bodies}
    waiting = list(bodies)
    for body in waiting:  # a tree comes again where it is handed more
        for call in body.calls():
            target, devices = call.target, call.target.document.devices
            given = {*call.devices, *found[id(body.signature)]} & devices.keys()
            more = {name for name in given if target.declared(name) is None} - found[id(target)]
            if more:
                found[id(target)] |= more
                waiting += [other for other in bodies if other.signature is target]
    return found


def _add(parent: ET.Element, part: Part, within: Signature, model: Model) -> None:
    tag, attributes = _element(part, within, model)
    element = ET.SubElement(parent, tag, {name: clean(text) for name, text in attributes.items()})
    if part.name and ":" not in part.name:
        element.set("name", part.name)
    for child in part.children():
        _add(element, child, within, model)


def _element(part: Part, within: Signature, model: Model) -> tuple[str, dict[str, str]]:
    """Return the tag and the attributes of a part of the tree `within`."""
    if isinstance(part, Leaf):
        tag, name = model.leaf(part.info)
        devices = {port: model.device(within, device) for port, device in part.devices.items()}
        return tag, {"ID": name, **devices, **_ports(part, part.info.types)}
    if isinstance(part, Call):
        types = {name: d.type for name, d in part.target.ins.items()}
        return "SubTree", {
            "ID": model.tree_name(part.target),
            **model.devices_of_call(within, part),
            **_ports(part, types),
        }
    known = _counterpart(part)
    return known if known is not None else model.construct(part)


def _ports(part: Leaf | Call, types: Mapping[str, Type]) -> dict[str, str]:
    found = {port_name(name): _input(wire, types[name]) for name, wire in part.inputs.items()}
    keys = part.outputs | part.inouts
    return found | {port_name(name): entry_of(key) for name, (key, _) in keys.items()}


def _input(wire: Wire, type_: Type) -> str:
    if wire.is_constant:
        return wire.text if wire.expression is None else as_text(wire.value, type_)
    key = wire.single_key()
    return wire.text if key is None else entry_of(key)


def _counterpart(part: Part) -> tuple[str, dict[str, str]] | None:
    """Return the built-in node of BehaviorTree.CPP that does the same, or None."""
    if part.keyword in _SAME:
        return _SAME[part.keyword], {}
    if isinstance(part, Parallel) and part.policy in _POLICIES:
        return "Parallel", {"success_count": _POLICIES[part.policy], "failure_count": "1"}
    if isinstance(part, Timeout) and part.after.is_constant:
        # 0 would be no timeout at all
        return "Timeout", {"msec": f"{max(part.after.value * 1e3, 1):.0f}"}
    if isinstance(part, Retry) and part.count.is_constant:
        return "RetryUntilSuccessful", {"num_attempts": str(part.count.value)}
    if isinstance(part, Repeat) and part.count.is_constant and not part.passes.written():
        return "Repeat", {"num_cycles": str(part.count.value)}
    return None
