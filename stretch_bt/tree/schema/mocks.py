"""The schema of mocks files: which nodes of a tree are replaced, and what the run must come to."""

from __future__ import annotations

from stretch_bt.hardware.interfaces import INTERFACES, readings_of
from stretch_bt.tree.fragments import Schema, ref
from stretch_bt.tree.registry import load_all
from stretch_bt.tree.schema.values import DRAFT, literal, value_definitions
from stretch_bt.tree.types import from_annotation

__all__ = ["mocks_schema"]

_STATUSES = ["success", "failure", "running"]
#: a file of arrays, SI
_ARRAY: Schema = {"type": "string", "pattern": r"\.np[yz](#.+)?$"}
_RESULTS = ["success", "failure", "error", "fault", "interrupted"]


def mocks_schema() -> Schema:
    """Return the schema; outputs of every registered node are offered."""
    return {
        "$schema": DRAFT,
        "title": "stretch-bt mocks",
        "type": "object",
        "required": ["format", "tree"],
        "additionalProperties": False,
        "properties": {
            "format": {"const": "stretch-mocks/1", "description": "every mocks file has it"},
            "doc": {"type": "string", "description": "what the mocks show"},
            "tree": {"type": "string", "description": "the tree that they are for: a shipped one, or a path from here"},
            "mocks": {"type": "array", "items": ref("mock"), "description": "the first that fits a path is taken"},
            "readings": _readings(),
            "expect": ref("expect"),
        },
        "$defs": {
            **value_definitions(),
            "mock": _mock(),
            "pattern": _pattern(),
            "patterns": _patterns(),
            "expect": _expect(),
        },
    }


def _pattern() -> Schema:
    text = "the path of a node; `*` stands for one segment, `**` for any number, `press[1]` for the second of its name"
    return {"type": "string", "minLength": 1, "description": text, "examples": ["**/press", "main/feel/*"]}


def _mock() -> Schema:
    status: Schema = {"enum": _STATUSES}
    return {
        "type": "object",
        "required": ["match"],
        "not": {"required": ["status", "status_when"]},
        "additionalProperties": False,
        "properties": {
            "match": ref("pattern"),
            "status": {
                "description": "how it ends; a list is worked through, one each time it ends (default success)",
                "anyOf": [status, {"type": "array", "minItems": 1, "items": status}],
            },
            "status_when": {"description": "SUCCESS when this holds, else FAILURE", "anyOf": [ref("condition")]},
            "after": {"description": "how long it takes (default 0 s)", "anyOf": [ref("literal_Time")]},
            "outputs": {
                "description": "what it writes on SUCCESS, by port: a value, or a list with one for each time",
                "type": "object",
                "properties": _outputs(),
                "additionalProperties": True,
            },
            "then": {
                "description": "what comes after the end of a list; `fail` comes after the end of the shortest one",
                "enum": ["repeat_last", "cycle", "fail"],
                "default": "repeat_last",
            },
            "message": {"type": "string", "description": "the reason that it gives for a FAILURE"},
        },
    }


def _outputs() -> Schema:
    """Return the output ports of all nodes, each with who writes it."""
    writers: dict[str, list[str]] = {}
    for info in load_all().values():
        for name, type_ in (info.outputs | info.inouts).items():
            writers.setdefault(name, []).append(f"{info.name} ({type_.name})")
    return {name: {"description": f"written by {', '.join(who)}"} for name, who in sorted(writers.items())}


def _readings() -> Schema:
    types = {name: from_annotation(a) for i in INTERFACES.values() for name, a in readings_of(i).items()}
    entries = {}
    for name, type_ in types.items():
        one = {"anyOf": [literal(type_) or {}, _ARRAY]}
        entries[rf"^\w+\.{name}$"] = {"anyOf": [*one["anyOf"], {"type": "array", "minItems": 1, "items": one}]}
    return {
        "type": "object",
        "patternProperties": entries,
        "additionalProperties": False,
        "description": "values that expressions read from devices, as in `arm.force: 1 N`; a list is worked through",
    }


def _patterns() -> Schema:
    return {"type": "array", "items": ref("pattern")}


def _expect() -> Schema:
    return {
        "type": "object",
        "additionalProperties": False,
        "description": "what the run must come to",
        "properties": {
            "result": {"enum": _RESULTS},
            "visited": {"description": "each must be ticked; `**/press#failure` must fail", "anyOf": [ref("patterns")]},
            "never": {"description": "none may be ticked", "anyOf": [ref("patterns")]},
            "outputs": {
                "description": "what outputs of the task must be: a value, or `{value: 1 N/mm, within: 5 %}`",
                "type": "object",
                "additionalProperties": {"anyOf": [ref("value"), _near()]},
            },
            "commands": {
                "description": "what must be commanded in this order, others between them aside",
                "type": "array",
                "items": {"type": "string", "pattern": r"^\w+\.\w+$", "examples": ["arm.move", "gripper.move"]},
            },
            "ticks_max": {"type": "integer", "minimum": 1},
        },
    }


def _near() -> Schema:
    within = "a share of the value in %, or a difference with the unit of the output"
    return {
        "type": "object",
        "required": ["value", "within"],
        "additionalProperties": False,
        "properties": {"value": ref("value"), "within": {"type": ["string", "number"], "description": within}},
    }
