"""Behaviour trees for the StRETcH tactile hand: written in YAML, checked before anything moves, run on a twin or a robot."""

from __future__ import annotations

TYPE_CHECKING = False  # of typing, which takes longer to import than all that stands before the handler of signals
if TYPE_CHECKING:
    from typing import Any

    from stretch_bt.runtime.check import check as check
    from stretch_bt.runtime.open_cell import open_cell as open_cell
    from stretch_bt.runtime.subtree import subtree as subtree
    from stretch_bt.runtime.task import run as run
    from stretch_bt.tree.ports import Behavior as Behavior
    from stretch_bt.tree.ports import In as In
    from stretch_bt.tree.ports import InOut as InOut
    from stretch_bt.tree.ports import Out as Out
    from stretch_bt.tree.ports import Status as Status
    from stretch_bt.tree.ports import Uses as Uses
    from stretch_bt.tree.ports import port as port
    from stretch_bt.tree.registry import node as node

__version__ = "0.1.0"
__all__ = [
    "Behavior",
    "In",
    "InOut",
    "Out",
    "Status",
    "Uses",
    "check",
    "node",
    "open_cell",
    "port",
    "run",
    "subtree",
]

_HOMES = {
    "Behavior": "tree.ports",
    "In": "tree.ports",
    "InOut": "tree.ports",
    "Out": "tree.ports",
    "Status": "tree.ports",
    "Uses": "tree.ports",
    "check": "runtime.check",
    "node": "tree.registry",
    "open_cell": "runtime.open_cell",
    "port": "tree.ports",
    "run": "runtime.task",
    "subtree": "runtime.subtree",
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
