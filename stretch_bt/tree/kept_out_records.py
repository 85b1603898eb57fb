"""Records that a called tree could use, that its caller has, and that it does not let in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from stretch_bt.errors import Diagnostic
from stretch_bt.tree.flow import Call, Leaf
from stretch_bt.tree.port import Role
from stretch_bt.tree.shared import shipped
from stretch_bt.tree.tree_body import TreeBody
from stretch_bt.tree.types import Type

__all__ = ["kept_out_records"]


def kept_out_records(body: TreeBody, bodies: Mapping[int, TreeBody]) -> Iterator[Diagnostic]:
    """Yield a warning at each call of a tree whose nodes go without a record that the caller has; shipped trees mean what they leave out."""
    for call in body.calls():
        inner = bodies.get(id(call.target))
        missed = {} if inner is None or _is_shipped(call) else _missed(inner)
        held = _held(body, call) if missed else {}
        for name, (type_, label) in missed.items():
            if name in held and type_.accepts(held[name]):
                message = f"{call.label!r} does not let in ${name}, so that its {label!r} goes without"
                hint = f"declare 'in: [{name}]' in {call.target.name!r}, or write '{name}: none' at {label!r}"
                yield call.mark.warning("record-kept-out", message, hint)


def _is_shipped(call: Call) -> bool:
    path = call.target.document.path
    return path is None or path.resolve().is_relative_to(shipped("").resolve())


def _held(body: TreeBody, call: Call) -> dict[str, Type]:
    """Return the records that a tree has at a call: those let in, and those that nodes and calls before it give."""
    here = (call.mark.line, call.mark.column)
    signature = body.signature
    found = {name: declared.type for name, declared in (signature.ins | signature.inouts).items()}
    for part in body.parts():
        if (part.mark.line, part.mark.column) >= here:
            continue
        if isinstance(part, Leaf):
            found |= part.info.outputs
        elif isinstance(part, Call):
            found |= {name: out.type for name, out in part.target.outs.items()}
    return {name: type_ for name, type_ in found.items() if type_.is_record}


def _missed(body: TreeBody) -> dict[str, tuple[Type, str]]:
    """Return the records that nodes of a tree could use and do not get, with the first such node of each."""
    found: dict[str, tuple[Type, str]] = {}
    for leaf in body.parts():
        if not isinstance(leaf, Leaf):
            continue
        for port in leaf.info.of(Role.INPUT):
            type_ = leaf.info.types[port.name]
            unknown = body.signature.declared(port.name) is None and port.name not in leaf.inputs
            if type_.is_record and not port.required and unknown:
                found.setdefault(port.name, (type_, leaf.label))
    return found
