"""The schema of tree files, made from the registry of nodes and the constructs of the language."""

from __future__ import annotations

from collections.abc import Mapping

from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.tree.flow import CONSTRUCTS, Part
from stretch_bt.tree.flow.guard import Guard, SkipIf
from stretch_bt.tree.flow.log import Log
from stretch_bt.tree.flow.repeat import Retry
from stretch_bt.tree.flow.timeout import Timeout
from stretch_bt.tree.fragments import WORDS, Schema, form, ref, short
from stretch_bt.tree.headings import FORMAT
from stretch_bt.tree.node_info import NodeInfo, first_paragraph
from stretch_bt.tree.registry import load_all, object_types
from stretch_bt.tree.schema.constructs import construct_schema
from stretch_bt.tree.schema.nodes import call_schema, described, must_be_written, node_schema
from stretch_bt.tree.schema.values import DRAFT, NAME, PLAIN, QUANTITIES, literal, value_definitions
from stretch_bt.tree.shared import SHARED
from stretch_bt.tree.shared_signatures import shared_signatures
from stretch_bt.tree.types import Family, Type

__all__ = ["tree_schema"]

#: a type that is one of several words
_OPTIONS = {"type": "string", "pattern": r"^\s*[a-z]\w*\s*(\|\s*[a-z]\w*\s*)+$"}
_BESIDE: dict[str, type[Part]] = {
    "timeout": Timeout,
    "retry": Retry,
    "guard": Guard,
    "skip_if": SkipIf,
    "log": Log,
}


def tree_schema(own: Mapping[str, NodeInfo]) -> Schema:
    """Return the schema, with every node that is registered now and those that a file imports as classes."""
    nodes = {**load_all(), **own}
    return {
        "$schema": DRAFT,
        "title": "stretch-bt tree",
        **_top(),
        "$defs": {
            **value_definitions(),
            **_words(),
            **_declarations(),
            **_places(nodes),
            **{f"construct_{name}": construct_schema(part) for name, part in CONSTRUCTS.items()},
            **{f"node_{name}": node_schema(info) for name, info in nodes.items()},
            **{f"node_{name}": call_schema(tree) for name, tree in shared_signatures().items()},
        },
    }


def _top() -> Schema:
    named = {"propertyNames": {"pattern": NAME}, "type": ["object", "null"]}
    return {
        "type": "object",
        "required": ["format", "trees"],
        "additionalProperties": False,
        "properties": {
            "format": {"const": FORMAT, "description": "every tree file has it"},
            "doc": {"type": "string", "description": "what the task does, in a sentence or two"},
            "imports": {
                "type": ["object", "null"],
                "additionalProperties": {"type": "string"},
                "description": "tree files, whose trees are then called `name.tree`, and Python modules with nodes",
            },
            "devices": {
                **named,
                "additionalProperties": {"enum": list(INTERFACES)},
                "description": "the devices that the trees use, by name and kind",
            },
            "scene": {"type": "string", "description": "the scene that `run` simulates when no scene or cell is named"},
            "tick": {"description": "time between two ticks, by default 50 ms", "anyOf": [ref("literal_Time")]},
            "params": {
                **named,
                "additionalProperties": ref("declaration"),
                "description": "constants of a run, which `--set name=value` changes",
            },
            "keys": {
                **named,
                "additionalProperties": ref("declaration"),
                "description": "what the nodes of `main` write and read, by name and type",
            },
            "trees": {
                "type": "object",
                "minProperties": 1,
                "propertyNames": {"pattern": NAME},
                "additionalProperties": ref("tree"),
                "description": "the trees of this file; a run ticks `main`, which may call the others",
            },
        },
    }


def _words() -> Schema:
    """Return the definitions of the reserved words beside a node."""
    own = {
        "name": {
            "type": "string",
            "pattern": r"^[A-Za-z_][\w-]*$",
            "description": "name of this place in paths, logs and mocks",
        },
        "doc": {"type": "string", "description": "purpose of this place"},
    }
    found: Schema = {}
    for word in WORDS:
        part = _BESIDE.get(word)
        schema = own[word] if part is None else part.schema_beside() or {}
        found[f"word_{word}"] = (
            schema if part is None else {"description": first_paragraph(part.__doc__), **described(schema)}
        )
    guarded = form({"that": ref("condition")}, {"name": ref("word_name")})
    one: Schema = {"anyOf": [ref("condition"), guarded]}
    found["conditions"] = {"anyOf": [*one["anyOf"], {"type": "array", "minItems": 1, "items": one}]}
    return found


def _declarations() -> Schema:
    """Return how params, keys, inputs and outputs are declared, each type with its own literals."""
    types = {**QUANTITIES, **PLAIN, **{n: Type(n, Family.OBJECT, cls=c) for n, c in object_types().items()}}
    lists = {f"list[{name}]": Type(f"list[{name}]", Family.LIST, item=type_) for name, type_ in types.items()}
    fields = ("default", "min", "max")
    whole: Schema = {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "type": ref("type"),
            "default": {"description": "the value unless another is given"},
            "min": {"description": "the least value allowed"},
            "max": {"description": "the greatest value allowed"},
            "unit": {"type": "string", "description": "the unit in which it is shown"},
            "doc": {"type": "string", "description": "what it means"},
            "scene": {
                "type": "boolean",
                "description": "of an output of 'main': the scene alone knows it, and nothing writes it",
            },
        },
        "allOf": [
            {
                "if": {"properties": {"type": {"const": name}}, "required": ["type"]},
                "then": {"properties": {f: _literal_of(type_, f) for f in fields}},
            }
            for name, type_ in {**types, **lists}.items()
            if literal(type_) is not None
        ],
    }
    return {
        "type": {
            "description": "a quantity, a plain type, an object that nodes hand on, or a list of one of them",
            # classes of modules that only the file imports are not known here, so any class name passes
            "anyOf": [{"enum": [*types, *lists]}, {"type": "string", "pattern": r"^(list\[)*[A-Z]\w*\]*$"}, _OPTIONS],
        },
        "declaration": {"anyOf": [ref("type"), whole, {"type": "null"}]},
    }


def _literal_of(type_: Type, field: str) -> Schema:
    """Return the schema of a default or a bound; a list is bounded item by item."""
    if field != "default":
        return literal(type_.item or type_) or {}
    return {"anyOf": [literal(type_) or {}, {"const": "none"}]}


def _places(nodes: dict[str, NodeInfo]) -> Schema:
    """Return the schemas of a place of a tree and of a whole tree."""
    names = {name: ref(f"construct_{name}") for name in CONSTRUCTS if name not in WORDS}
    names |= {name: ref(f"node_{name}") for name in (*nodes, *SHARED)}
    names["run"] = {"description": "Call a tree by name.", "anyOf": [ref("text"), form({"tree": ref("text")}, _with())]}
    names |= _with()
    both = {word: {"anyOf": [ref(f"word_{word}"), ref(f"construct_{word}")]} for word in WORDS if word in CONSTRUCTS}
    words = {word: ref(f"word_{word}") for word in WORDS} | both
    bare = [name for name, info in nodes.items() if not must_be_written(info)]
    beside: Schema = {"anyOf": [{"required": [word]} for word in (*WORDS, "with")]}
    return {
        "call": {
            "type": ["object", "null"],
            "description": "a call of a tree: its inputs and outputs",
            "additionalProperties": short(ref("value")),
        },
        "node": {
            "type": "object",
            "minProperties": 1,
            "properties": {**names, **words},
            "additionalProperties": ref("call"),
            "if": {"not": beside},
            "then": {"maxProperties": 1},
        },
        "bare": {
            "type": "string",
            "description": "a node without ports, or a tree",
            "anyOf": [{"enum": bare}, {"not": {"enum": [*CONSTRUCTS, *nodes]}}],
        },
        "children": {"type": "array", "minItems": 1, "items": ref("body")},
        "body": {"anyOf": [ref("node"), ref("children"), ref("bare")]},
        "headed": {
            "type": "object",
            "minProperties": 1,
            "properties": {**names, **words, **_border(), "finally": _finally()},
            "additionalProperties": ref("call"),
        },
        "tree": {"anyOf": [ref("headed"), ref("children"), ref("bare")]},
    }


def _with() -> Schema:
    return {"with": ref("call")}


def _border() -> Schema:
    docs = {
        "in": "what a caller gives",
        "inout": "what it reads and writes of its caller's",
        "out": "what it hands back",
        "keys": "its own keys, fresh at each call",
    }
    declared = {
        "type": ["object", "null"],
        "propertyNames": {"pattern": NAME},
        "additionalProperties": ref("declaration"),
    }
    listed: Schema = {"type": "array", "items": {"type": "string", "pattern": NAME}}
    both: Schema = {"anyOf": [declared, listed]}
    return {name: {**(declared if name == "keys" else both), "description": doc} for name, doc in docs.items()} | {
        "doc": {"type": "string", "description": "what the tree does"}
    }


def _finally() -> Schema:
    text = "what runs at the end, however the tree ended"
    return {"description": text, "anyOf": [ref("node"), ref("children"), ref("bare"), {"type": "null"}]}
