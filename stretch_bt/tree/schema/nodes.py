"""Schemas of registered nodes: their ports, with types, units, bounds and docs."""

from __future__ import annotations

from typing import Any

from stretch_bt.quantity_text import format_quantity
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.document import Signature
from stretch_bt.tree.fragments import Schema, ref, short
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.schema.values import wired
from stretch_bt.tree.types import Family, Type

__all__ = ["as_text", "bounds_text", "call_schema", "described", "must_be_written", "node_schema"]


def node_schema(info: NodeInfo) -> Schema:
    """Return the schema of what follows a node's name."""
    ports = {port.name: short(_port(port, info.types[port.name])) for port in info.ports.values()}
    ports |= {name: short(_output(info, name, type_)) for name, type_ in info.outputs.items()}
    required = must_be_written(info)
    return {
        "title": info.name,
        "description": info.doc,
        "type": "object" if required else ["object", "null"],
        "properties": ports,
        **({"required": required} if required else {}),
        "additionalProperties": False,
    }


def call_schema(tree: Signature) -> Schema:
    """Return the schema of the value after the name of a shipped tree that is called like a node."""
    ins = {
        d.name: short({"description": _sentence(d.doc, [d.type.name]), **described(wired(d.type))})
        for d in tree.ins.values()
    }
    docs = {d.name: (d.doc, d.type) for d in (*tree.inouts.values(), *tree.outs.values())}
    docs |= {name: (f"standard deviation of {d.name}", d.type) for name, d in tree.deviations.items()}
    outs = {
        name: short({"description": _sentence(doc, [type_.name, "output"]), **described(ref("key"))})
        for name, (doc, type_) in docs.items()
    }
    needed = [d.name for d in tree.ins.values() if not d.has_default and not d.type.is_record]
    return {
        "title": tree.name,
        "description": tree.doc,
        "type": "object" if needed else ["object", "null"],
        "properties": ins | outs,
        **({"required": needed} if needed else {}),
        "additionalProperties": False,
    }


def must_be_written(info: NodeInfo) -> list[str]:
    """Return the ports without which a node cannot be written."""
    return [port.name for port in info.ports.values() if port.required and not _left_out(info, port)]


def _left_out(info: NodeInfo, port: Port) -> bool:
    """Whether a port that a node needs may be left out: a record is wired by its name, and an error goes with its value."""
    return info.types[port.name].is_record or (
        port.name.endswith("_sd") and port.name.removesuffix("_sd") in info.ports
    )


def as_text(value: Any, type_: Type) -> str:
    """Return a value of Python as a file would have it."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(as_text(item, type_.item or type_) for item in value)}]"
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    if type_.family is Family.QUANTITY:
        return format_quantity(value, type_.kind, 6)
    return f"{value:g}" if isinstance(value, float) else str(value)


def bounds_text(low: float | None, high: float | None, type_: Type) -> str:
    """Return bounds in words, or nothing when there are none."""
    type_ = type_.item or type_
    if low is None and high is None:
        return ""
    if high is None:
        return f"at least {as_text(low, type_)}"
    if low is None:
        return f"at most {as_text(high, type_)}"
    return f"{as_text(low, type_)} to {as_text(high, type_)}"


def _port(port: Port, type_: Type) -> Schema:
    if port.role is Role.DEVICE:
        optional = ", used where the file declares one" if port.optional else ""
        text = f"{port.doc or port.name} ({type_.name}{optional}); by default the device of this name, or the only one"
        return {"type": "string", "pattern": r"^\$?[A-Za-z_]\w*$", "description": text}
    facts = [type_.name, bounds_text(port.min, port.max, type_)]
    given = port.default is not MISSING and port.default is not None
    facts.append("read and written" if port.role is Role.INOUT else "")
    facts.append(f"default {as_text(port.default, type_)}" if given else "" if not port.required else "required")
    found: Schema = {
        "description": _sentence(port.doc, facts),
        **described(ref("key") if port.role is Role.INOUT else wired(type_)),
    }
    if given:
        found["default"] = _as_json(port.default, type_)
    return found


def _as_json(value: Any, type_: Type) -> Any:
    """Return a value as a file would have it, quantities with their unit."""
    if type_.family is Family.LIST:
        return [_as_json(item, type_.item or type_) for item in value]
    plain = type_.family in (Family.BOOL, Family.INT, Family.FLOAT)
    return value if plain else as_text(value, type_)


def _output(info: NodeInfo, name: str, type_: Type) -> Schema:
    declared = info.ports.get(name)
    doc = declared.doc if declared else f"standard deviation of {name.removesuffix('_sd')}"
    return {"description": _sentence(doc, [type_.name, "output"]), **described(ref("key"))}


def _sentence(doc: str, facts: list[str]) -> str:
    inside = ", ".join(fact for fact in facts if fact)
    return f"{doc} ({inside})" if doc else inside


def described(schema: Schema) -> Schema:
    """Return a schema that may stand beside a description, which a bare reference may not."""
    return {"anyOf": [schema]} if "$ref" in schema else schema
