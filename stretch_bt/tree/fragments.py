"""Pieces of JSON Schema that the constructs of the language share."""

from __future__ import annotations

from typing import Any

from stretch_bt.tree.registry import RESERVED

__all__ = ["WORDS", "Schema", "form", "ref"]

Schema = dict[str, Any]

#: reserved words that may stand beside a node, or among its ports; `finally` belongs to trees
WORDS = tuple(word for word in RESERVED if word != "finally")


def ref(name: str) -> Schema:
    """Return a reference to a definition of the schema."""
    return {"$ref": f"#/$defs/{name}"}


def form(required: dict[str, Schema], optional: dict[str, Schema] | None = None) -> Schema:
    """Return the schema of a mapping with these fields, the reserved words, and nothing else."""
    words = {word: ref(f"word_{word}") for word in WORDS}
    return {
        "type": "object",
        "properties": {**required, **(optional or {}), **words},
        "required": list(required),
        "additionalProperties": False,
    }
