"""The node that a test names: one of ours, one of its own, or a class of py_trees."""

from __future__ import annotations

import sys
from pathlib import Path

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.own_modules import ModuleRefused, Modules
from stretch_bt.source import did_you_mean
from stretch_bt.tree.foreign.of_class import class_in, classes_in, info_of
from stretch_bt.tree.foreign.refused import BehaviourRefused
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.registry import load_all, lookup

__all__ = ["node_info"]


def node_info(name: str | type, home: Path) -> NodeInfo:
    """Return a node by its name, by `module.name`, or by its class; the module may stand in the folder `home`.

    A class of behaviours of py_trees, or of another package, is a node as where a tree imports it.

    Raises
    ------
    InvalidInput
        There is none; the message has the nearest name, or what to do.
    """
    if isinstance(name, type):
        return _of_class(name)
    module, _, last = name.rpartition(".")
    if module and module not in sys.modules and lookup(name) is None:
        try:
            Modules(home, home, "put the module beside the test, or install the package").bring(module, home / "test")
        except ModuleRefused as refused:
            raise InvalidInput(f"node {name!r}: {refused}; {refused.hint}") from None
    cls = class_in(module, last) if module in sys.modules else None
    if cls is not None:
        return _of_class(cls)
    found = lookup(last)
    if found is None:
        raise InvalidInput(_no_node(last, module))
    return found


def _of_class(cls: type) -> NodeInfo:
    registered = next((info for info in load_all().values() if info.cls is cls), None)
    if registered is not None:
        return registered
    try:
        return info_of(cls)
    except BehaviourRefused as refused:
        hint = f"{refused.hint}; a whole tree is ticked by tick_task"
        raise InvalidInput(f"{refused}; {hint}") from None


def _no_node(name: str, module: str) -> str:
    top = module.partition(".")[0]
    own = [known for known, info in load_all().items() if info.cls.__module__.partition(".")[0] == top]
    if module:
        own += classes_in(module)
    if own and module:
        return f"module {module!r} has no node {name!r}; {did_you_mean(name, own)}"
    hint = did_you_mean(name, load_all()) or "`stretch-bt nodes` lists them"
    return f"no node {name!r} is registered; {hint}, or import the module of your own node"
