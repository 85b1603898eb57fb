"""Fitting a file to a pydantic model, with every mistake at its place."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from typing import Any, TypeVar

from stretch_bt.errors import Diagnostic, FileError
from stretch_bt.source.suggest import closest, did_you_mean, few_suggestions, unknown_key
from stretch_bt.source.values import TRUTHS, Map, Scalar, Seq, Value

__all__ = ["FILE_KINDS", "validate"]

M = TypeVar("M")
#: by how formats begin: what files are
FILE_KINDS = {
    "stretch-tree": "tree",
    "stretch-scene": "scene",
    "stretch-cell": "cell",
    "stretch-mocks": "mocks file",
    "stretch-sweep": "sweep",
}


@few_suggestions()
def validate(model: type[M], value: Value) -> M:
    """Fit a value to a pydantic model; raises FileError with every mistake at its place."""
    from pydantic import TypeAdapter, ValidationError

    try:
        return TypeAdapter(model).validate_python(value.plain())
    except ValidationError as error:
        found = error.errors(include_url=False)
        _check_kind(value, found)
        missing = [e for e in found if e["type"] == "missing"]
        for e in found:  # a misspelt key is also missing under its right name
            if e["type"] == "extra_forbidden":
                beside = [m for m in missing if m["loc"][:-1] == e["loc"][:-1]]
                meant = closest(str(e["loc"][-1]), [str(m["loc"][-1]) for m in beside])
                found = found if meant is None else [m for m in found if m not in beside or m["loc"][-1] != meant]
        raise FileError([_explain(model, value, e) for e in found]) from None


def _check_kind(root: Value, errors: Sequence[Any]) -> None:
    """Refuse a file of another kind by that alone: none of its keys is one of the kind that is wanted."""
    wrong = next((e for e in errors if e["loc"] == ("format",) and e["type"] == "literal_error"), None)
    given = root.get("format") if isinstance(root, Map) else None
    if wrong is None or not isinstance(given, Scalar):
        return
    wanted = wrong["ctx"]["expected"].strip("'")
    kind, here = given.text.partition("/")[0], wanted.partition("/")[0].removeprefix("stretch-")
    if kind in FILE_KINDS and kind != f"stretch-{here}":
        what = f"this is a {FILE_KINDS[kind]}, and a {here} is wanted"
        raise FileError([given.mark.error("format-unknown", what, f"name a file that begins with 'format: {wanted}'")])


def _explain(model: type, root: Value, error: Any) -> Diagnostic:
    """Turn one pydantic error into a diagnostic at the place it speaks of."""
    value, path = _locate(root, error["loc"])
    where = ".".join(path)
    kind = error["type"]
    if kind == "extra_forbidden":
        parent, _ = _locate(root, error["loc"][:-1])
        key = str(error["loc"][-1])
        mark = parent.key(key).mark if isinstance(parent, Map) and key in parent else value.mark
        hint = unknown_key(Scalar(key, False, mark), value, _field_names(model, error["loc"][:-1]))
        return mark.error("key-unknown", f"unknown key {key!r}", hint)
    if kind == "missing":
        return value.mark.error("key-missing", f"{where} is missing", f"add '{error['loc'][-1]}: ...'")
    if kind == "too_short":
        least, given = error["ctx"]["min_length"], error["ctx"]["actual_length"]
        entries = "at least one entry" if least == 1 else f"at least {least} entries"
        return value.mark.error("value", f"{where} takes {entries}, not {given}", f"write {entries}")
    if kind == "model_attributes_type" and isinstance(value, Scalar):
        return value.mark.error(
            "value", f"{where} takes a mapping, not {value.text!r}", f"write '{{type: {value.text}}}'"
        )
    if kind == "string_too_short":
        return value.mark.error("value", f"{where} is empty", "write what it names, or leave it out")
    wanted = next((what for start, what in _WANTED.items() if kind.startswith(start)), None)
    if wanted is not None:
        given = repr(value.text) if isinstance(value, Scalar) else "this"
        return value.mark.error("value", f"{where} takes {wanted[0]}, not {given}", _as_wanted(value, *wanted))
    message = error["msg"].removeprefix("Value error, ")
    message, _, hint = message.partition("; ")
    return value.mark.error("value", ": ".join(filter(None, (where, message))), hint or _expectation(error))


#: by the beginning of a pydantic error type: what is wanted, and an example
_WANTED = {
    "bool": ("true or false", "true"),
    "int": ("a whole number", "3"),
    "float": ("a number", "0.5"),
    "string": ("text", "'text'"),
    "model_": ("a mapping", "{name: value}"),
    "dict": ("a mapping", "{name: value}"),
    "list": ("a list", "[value]"),
    "tuple": ("a list", "[value]"),
}


def _as_wanted(value: Value, wanted: str, sample: str) -> str:
    if isinstance(value, Scalar) and wanted == "true or false" and value.text.lower() in TRUTHS:
        return f"write '{TRUTHS[value.text.lower()]}'"
    if isinstance(value, Scalar) and wanted == "text":
        return "put quotes around it"
    if isinstance(value, Scalar) and value.quoted and Scalar(value.text, False, value.mark).value != value.text:
        return "remove the quotes"
    return f"write {wanted}, as in {sample}"


def _expectation(error: Any) -> str:
    context = error.get("ctx", {})
    expected, given = context.get("expected"), error.get("input")
    if expected and isinstance(given, str):
        options = re.findall(r"'([^']*)'", expected)
        return did_you_mean(given, options)
    bounds = (("ge", "at least"), ("gt", "more than"), ("le", "at most"), ("lt", "less than"))
    limits = " and ".join(f"{word} {context[name]}" for name, word in bounds if name in context)
    if limits:
        return f"write {limits}"
    return f"expected {expected}" if expected else "see the schema of this file"


def _locate(root: Value, loc: Sequence[str | int]) -> tuple[Value, list[str]]:
    """Follow a pydantic location as far as the file goes; tags of unions are passed over."""
    value, path = root, []
    for step in loc:
        if isinstance(value, Map) and str(step) in value:
            value = value.get(str(step)) or value
            path.append(str(step))
        elif isinstance(value, Seq) and isinstance(step, int) and step < len(value.items):
            value = value.items[step]
            path.append(str(step))
        elif step is loc[-1] and isinstance(value, Map):
            path.append(str(step))
    return value, path


def _field_names(model: Any, loc: Sequence[str | int]) -> list[str]:
    """Return every field name reachable under a location, by the model's JSON schema."""
    schema = _schema(model)
    definitions = schema.get("$defs", {})
    nodes = [schema]
    for step in loc:
        nodes = [n for node in nodes for n in _children(node, step, definitions)]
    return sorted({name for node in nodes for n in _variants(node, definitions) for name in n.get("properties", {})})


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
