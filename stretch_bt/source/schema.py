"""What the JSON schema of a pydantic model says of a place in a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from typing import Any

__all__ = ["field_names", "may_be_left_out", "sample"]


def field_names(model: Any, loc: Sequence[str | int]) -> list[str]:
    """Return every field name reachable under a location, by the model's JSON schema."""
    definitions = _definitions(model)
    nodes = _nodes(model, loc)
    return sorted({name for node in nodes for n in _variants(node, definitions) for name in n.get("properties", {})})


def sample(model: Any, loc: Sequence[str | int]) -> str:
    """Return what may be written at a location, such as `1 mm` or `sheet`, or nothing where the schema does not say."""
    definitions = _definitions(model)
    for node in _nodes(model, loc):
        for said in (node, *_variants(node, definitions)):
            text = _sample(said, node, definitions)
            if text:
                return text
    return ""


def may_be_left_out(model: Any, loc: Sequence[str | int]) -> bool:
    """Return whether a file may go without the key at a location."""
    definitions = _definitions(model)
    parents = [n for node in _nodes(model, loc[:-1]) for n in _variants(node, definitions)]
    return not any(
        loc[-1] in parent.get("required", ()) or loc[-1] not in parent.get("properties", {}) for parent in parents
    )


def _sample(said: dict[str, Any], node: dict[str, Any], definitions: dict[str, Any]) -> str:
    """Return an example of a part of a schema: of a mapping, its first key; `node` is the whole that it is a part of."""
    told = [*said.get("examples", ()), *said.get("enum", ()), *([said["const"]] if "const" in said else [])]
    if told:
        return _written(told[0])
    tags = node.get("discriminator", {})
    if tags:
        return f"{{{tags['propertyName']}: {next(iter(tags['mapping']))}, ...}}"
    properties = said.get("properties", {})
    if properties:
        first = next(iter(said.get("required") or properties))
        value = next(
            filter(None, (_sample(n, n, definitions) for n in _variants(properties[first], definitions))), "..."
        )
        return f"{{{first}: {value}}}"
    return _BY_TYPE.get(str(said.get("type")), "")


_BY_TYPE = {"integer": "3", "number": "0.5", "boolean": "true", "array": "[...]", "object": "{name: value}"}


def _written(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _definitions(model: Any) -> dict[str, Any]:
    found: dict[str, Any] = _schema(model).get("$defs", {})
    return found


def _nodes(model: Any, loc: Sequence[str | int]) -> list[dict[str, Any]]:
    """Return the parts of a schema that a location may stand for."""
    nodes = [_schema(model)]
    for step in loc:
        nodes = [n for node in nodes for n in _children(node, step, _definitions(model))]
    return nodes


@cache
def _schema(model: Any) -> dict[str, Any]:
    """Return the JSON schema of a model, made once: it takes longer than all else that is done about a mistake."""
    from pydantic import TypeAdapter

    return TypeAdapter(model).json_schema()


def _variants(node: dict[str, Any], definitions: dict[str, Any]) -> list[dict[str, Any]]:
    if "$ref" in node:
        return _variants(definitions[node["$ref"].rpartition("/")[2]], definitions)
    options = node.get("anyOf", []) + node.get("oneOf", [])
    return [v for option in options for v in _variants(option, definitions)] or [node]


def _children(node: dict[str, Any], step: str | int, definitions: dict[str, Any]) -> list[dict[str, Any]]:
    tagged = node.get("discriminator", {}).get("mapping", {}).get(str(step))
    if tagged is not None:
        return [{"$ref": tagged}]
    found: list[dict[str, Any]] = []
    for variant in _variants(node, definitions):
        properties = variant.get("properties", {})
        if str(step) in properties:
            found.append(properties[str(step)])
        elif isinstance(step, int) and "items" in variant:
            found.append(variant["items"])
        elif isinstance(variant.get("additionalProperties"), dict):
            found.append(variant["additionalProperties"])
        else:  # the tag of a union
            found.append(variant)
    return found
