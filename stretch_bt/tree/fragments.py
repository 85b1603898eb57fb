"""Pieces of JSON Schema that the constructs of the language share."""

from __future__ import annotations

from typing import Any

from stretch_bt.tree.registry import RESERVED

__all__ = ["WORDS", "Schema", "form", "ref", "short"]

Schema = dict[str, Any]

#: reserved words that may stand beside a node; `finally` belongs to trees
WORDS = tuple(word for word in RESERVED if word != "finally")


def ref(name: str) -> Schema:
    """Return a reference to a definition of the schema."""
    return {"$ref": f"#/$defs/{name}"}


def short(schema: Schema) -> Schema:
    """Return the schema of a port, which takes the key of its own name where nothing is written."""
    nothing: Schema = {"type": "null"}
    if "anyOf" in schema:
        return {**schema, "anyOf": [*schema["anyOf"], nothing]}
    inner = {name: value for name, value in schema.items() if name not in ("description", "default")}
    outer = {name: value for name, value in schema.items() if name in ("description", "default")}
    return {**outer, "anyOf": [inner, nothing]}


def form(required: dict[str, Schema], optional: dict[str, Schema] | None = None) -> Schema:
    """Return the schema of a mapping with these fields and nothing else."""
    return {
        "type": "object",
        "properties": {**required, **(optional or {})},
        "required": list(required),
        "additionalProperties": False,
    }
