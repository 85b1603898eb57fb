"""Schemas of values: literals with their units, and what may feed an input instead of one."""

from __future__ import annotations

from stretch_bt.tree.fragments import Schema, ref
from stretch_bt.tree.types import BOOL, FLOAT, INT, STR, Family, Type
from stretch_bt.units import KINDS, NUMBER, Kind, unit_names

__all__ = ["DRAFT", "NAME", "PLAIN", "QUANTITIES", "literal", "value_definitions", "wired"]

#: the YAML language server reads later drafts only in its newest releases, and partly
DRAFT = "http://json-schema.org/draft-07/schema#"

NAME = r"^[A-Za-z_]\w*$"
QUANTITIES = {kind.name: Type(kind.name, Family.QUANTITY, kind.dimension) for kind in KINDS.values()}
PLAIN = {type_.name: type_ for type_ in (BOOL, INT, FLOAT, STR)}

#: a unit made of others, such as N/mm; only `check` works out its dimension
_COMPOUND = r"(?=\S*\s?[/^*²³·])[A-Za-zµ1][\w /^*²³·µ-]*"
_NUMBER_ALONE = rf"\s*(?:{NUMBER}\s*(?:[A-Za-z%µ][\w/%^µ²³]*|1/[A-Za-z]\w*)?|[-+]?\.(?:inf|nan|Inf|NaN|INF|NAN))\s*"
_KEY_SNIPPETS = [
    {"label": "$key", "description": "the value of a key, an input or a param", "body": r"\$${1:key}"},
]


def literal(type_: Type) -> Schema | None:
    """Return the schema of a literal of this type; None where there is none, as for objects."""
    if type_.family is Family.QUANTITY:
        return (
            ref(f"literal_{type_.name}") if type_.name in QUANTITIES else {"type": "string", "pattern": r"^\s*[-+.\d]"}
        )
    if type_.family is Family.ENUM:
        return {"enum": list(type_.members or type_.options)}
    if type_.family is Family.LIST:
        item = None if type_.item is None else literal(type_.item)
        return None if item is None else {"type": "array", "items": item}
    return ref(f"literal_{type_.name}") if type_.name in PLAIN else None


def wired(type_: Type) -> Schema:
    """Return the schema of what may feed an input: a literal, `$name` or an expression."""
    if type_.family is Family.QUANTITY and type_.name in QUANTITIES:
        return ref(f"input_{type_.name}")
    if type_.family is Family.ANY:
        return ref("value")
    if type_ is STR or type_.family is Family.STR:
        return ref("literal_str")
    if type_.family is Family.ENUM:
        return {"anyOf": [{"enum": list(type_.members or type_.options)}, ref("reference")]}
    if type_.family is Family.LIST and type_.item is not None and literal(type_.item) is not None:
        return {"anyOf": [{"type": "array", "items": wired(type_.item)}, ref("expression")]}
    plain = literal(type_)
    return ref("expression") if plain is None else {"anyOf": [plain, ref("expression")]}


def _quantity(kind: Kind) -> Schema:
    simple = sorted(unit_names(kind.dimension), key=lambda unit: unit != kind.unit)
    units = "|".join([*simple, *(["µm"] if "um" in simple else []), _COMPOUND])
    offered = [unit for unit in simple if "/" not in unit] or [kind.unit]
    return {
        "type": "string",
        "pattern": rf"^\s*{NUMBER}\s*(?:{units})\s*$",
        "patternErrorMessage": f"this is no {kind.name}; write a number and its unit, as in '10 {kind.unit}'",
        "defaultSnippets": [
            {"label": f"10 {unit}", "description": kind.name, "body": f"${{1:10}} {unit}"} for unit in offered
        ],
    }


def value_definitions() -> Schema:
    """Return the definitions that `literal` and `wired` refer to."""
    found: Schema = {
        "literal_bool": {"type": "boolean"},
        "literal_int": {"type": "integer"},
        "literal_float": {"anyOf": [{"type": "number"}, {"type": "string", "pattern": rf"^\s*{NUMBER}\s*%\s*$"}]},
        "literal_str": {"type": ["string", "number", "boolean"]},
        "key": {
            "type": "string",
            "pattern": r"^\$[A-Za-z_]\w*$",
            "patternErrorMessage": "an output takes a $key of this tree",
            "defaultSnippets": _KEY_SNIPPETS[:1],
        },
        "reference": {"type": "string", "pattern": r"^\$", "defaultSnippets": _KEY_SNIPPETS},
        "expression": {
            "type": "string",
            "pattern": rf"^(?!{_NUMBER_ALONE}$)[\s\S]*\S",
            "patternErrorMessage": "a number here needs its unit; otherwise write $name or an expression",
            "defaultSnippets": _KEY_SNIPPETS,
        },
        "condition": {"type": ["string", "boolean"], "minLength": 1},
        "count": {"anyOf": [{"type": "integer", "minimum": 1}, ref("expression")]},
        "input_list": {"anyOf": [{"type": "array"}, ref("expression")]},
        "value": {"type": ["string", "number", "boolean", "array"]},
        "text": {"type": "string", "minLength": 1},
    }
    for name, kind in KINDS.items():
        found[f"literal_{name}"] = _quantity(kind)
        found[f"input_{name}"] = {"anyOf": [ref(f"literal_{name}"), ref("expression")]}
    return found
