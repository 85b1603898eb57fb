"""Registered nodes and records as plain data, for people and editors."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterable
from typing import Any

from stretch_bt.source.comments import comments_of
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.types import Type, attributes
from stretch_bt.units import Estimate

__all__ = ["describe", "fields_of", "records_of"]


def describe(info: NodeInfo) -> dict[str, Any]:
    """Return what `nodes --json` prints of a node."""
    return {
        "name": info.name,
        "kind": info.cls.kind,
        "doc": info.doc,
        "module": info.cls.__module__,
        "inputs": [_describe_port(info, p) for p in info.of(Role.INPUT)],
        "outputs": [_describe_output(info, name, type_) for name, type_ in info.outputs.items()],
        "inouts": [_describe_port(info, p) for p in info.of(Role.INOUT)],
        "devices": [
            {"name": p.name, "type": info.types[p.name].name, "required": not p.optional} for p in info.of(Role.DEVICE)
        ],
        "records": records_of(info.types[p.name] for p in info.ports.values() if p.role is not Role.DEVICE),
    }


def records_of(types: Iterable[Type]) -> dict[str, list[dict[str, Any]]]:
    """Return the fields of the records among some types, by the name of the type."""
    classes = {(type_.item or type_).name: (type_.item or type_).cls for type_ in types if type_.is_record}
    return {name: fields_of(cls) for name, cls in classes.items() if cls is not None}


def _describe_port(info: NodeInfo, declared: Port) -> dict[str, Any]:
    type_ = info.types[declared.name]
    kind = type_.kind
    entry = {
        "name": declared.name,
        "type": type_.name,
        "unit": kind.si_unit if kind else None,
        "default": _plain_default(declared.default),
        "required": declared.required,
        "doc": declared.doc,
    }
    bounds = {"min": declared.min, "max": declared.max}
    return entry | {k: v for k, v in bounds.items() if v is not None}


def _describe_output(info: NodeInfo, name: str, type_: Type) -> dict[str, Any]:
    declared = info.ports.get(name)
    doc = declared.doc if declared else f"standard deviation of {name.removesuffix('_sd')}"
    return {"name": name, "type": type_.name, "unit": type_.kind.si_unit if type_.kind else None,
            "default": None, "required": False, "doc": doc}  # fmt: skip


def fields_of(cls: type) -> list[dict[str, Any]]:
    """Return what expressions may read of a record: name, type, unit and doc of each field."""
    docs = comments_of(cls)
    return [
        {
            "name": name,
            "type": type_.name,
            "unit": type_.kind.si_unit if type_.kind else None,
            "doc": docs.get(name) or (inspect.getdoc(getattr(cls, name, None)) or "").partition("\n")[0],
        }
        for name, type_ in attributes(cls).items()
    ]


def _plain_default(default: Any) -> Any:
    if default is MISSING:
        return None
    if isinstance(default, Estimate) or dataclasses.is_dataclass(default):
        return repr(default)
    return list(default) if isinstance(default, tuple) else default
