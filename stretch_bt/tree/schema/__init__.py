"""JSON Schemas of the files that people write, for completion and hover text in editors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean
from stretch_bt.tree.fragments import Schema

if TYPE_CHECKING:
    from stretch_bt.tree.node_info import NodeInfo

__all__ = ["schema"]

_NONE: Mapping[str, NodeInfo] = MappingProxyType({})


def schema(kind: str, own: Mapping[str, NodeInfo] = _NONE) -> Schema:
    """Return the JSON Schema of files of this kind: `tree`, `mocks`, `scene`, `cell` or `sweep`.

    Trees and mocks are in draft-07, the newest that every release of the YAML language server understands; they hold all
    nodes that are registered now, also of installed packages; the schema of trees has `own` nodes too, classes that a file imports.

    Raises
    ------
    InvalidInput
        There are no files of this kind.
    """
    if kind not in _SCHEMAS:
        hint = did_you_mean(kind, _SCHEMAS) or f"one of {', '.join(_SCHEMAS)}"
        raise InvalidInput(f"there is no schema of {kind!r}; {hint}")
    return _tree(own) if kind == "tree" else _SCHEMAS[kind]()


def _tree(own: Mapping[str, NodeInfo] = _NONE) -> Schema:
    from stretch_bt.tree.schema.tree import tree_schema

    return tree_schema(own)


def _mocks() -> Schema:
    from stretch_bt.tree.schema.mocks import mocks_schema

    return mocks_schema()


def _scene() -> Schema:
    from stretch_bt.simulation.scene import scene_schema

    return scene_schema()


def _cell() -> Schema:
    from stretch_bt.hardware.cell_file import cell_schema

    return cell_schema()


def _sweep() -> Schema:
    from stretch_bt.tree.sweep_file import sweep_schema

    return sweep_schema()


_SCHEMAS: dict[str, Callable[[], Schema]] = {
    "tree": _tree,
    "mocks": _mocks,
    "scene": _scene,
    "cell": _cell,
    "sweep": _sweep,
}
