"""Schemas of the constructs of the language, and what `nodes` says of them."""

from __future__ import annotations

from typing import Any

from stretch_bt.tree.flow import CONSTRUCTS, Part
from stretch_bt.tree.fragments import Schema
from stretch_bt.tree.node_info import first_paragraph
from stretch_bt.tree.schema.nodes import described

__all__ = ["KIND", "construct_schema", "describe_construct"]

KIND = "construct"
#: value that a field takes, by the definition that its schema refers to
_TYPES = {
    "body": "a place, or a list of places",
    "children": "a list of places",
    "condition": "condition",
    "count": "int",
    "input_list": "list",
    "input_Time": "Time",
    "key": "a key",
    "text": "text",
    "word_name": "text",
}


def construct_schema(part: type[Part]) -> Schema:
    """Return the schema of what follows the word of a construct."""
    return {"title": part.keyword, "description": first_paragraph(part.__doc__), **described(part.schema() or {})}


def describe_construct(name: str) -> dict[str, Any]:
    """Return what `nodes --json` prints of a construct, in the form of a node: its fields are inputs."""
    part = CONSTRUCTS[name]
    return {
        "name": name,
        "kind": KIND,
        "doc": first_paragraph(part.__doc__),
        "module": part.__module__,
        "inputs": _fields(part.schema() or {}),
        "outputs": [],
        "inouts": [],
        "devices": [],
        "records": {},
    }


def _fields(schema: Schema) -> list[dict[str, Any]]:
    """Return the fields of the form that has any; a construct without them takes what stands after its word."""
    forms = [schema, *schema.get("anyOf", ())]
    found: Schema = next((form for form in forms if "properties" in form), {"properties": {}})
    return [
        {
            "name": name,
            "type": _type(field),
            "unit": None,
            "default": None,
            "required": name in found.get("required", ()),
            "doc": field.get("description", ""),
        }
        for name, field in found["properties"].items()
    ]


def _type(field: Schema) -> str:
    if "enum" in field:
        return " | ".join(field["enum"])
    if "$ref" in field:
        return _TYPES[field["$ref"].rpartition("/")[2]]
    return {"object": "mapping", "array": "list"}[field["type"]]
