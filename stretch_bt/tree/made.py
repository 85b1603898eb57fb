"""Making one node of its class, and refusing one that lacks what every node has, at its place where it has one."""

from __future__ import annotations

from functools import cache

from stretch_bt.blame import own_code
from stretch_bt.errors import NodeError, StretchError, TreeError, shown
from stretch_bt.source import Mark
from stretch_bt.tree.behavior import Behavior

__all__ = ["base_attributes", "made", "made_at"]


def made_at(cls: type[Behavior], path: str, mark: Mark) -> Behavior:
    """Return a node of this class for a place of a file; raises TreeError, at that place, for a class whose nodes cannot run."""
    if cls.update is Behavior.update:
        message = f"{cls.__name__} does not override update()"
        raise TreeError([mark.error("import", message, "write 'def update(self) -> Status'")])
    try:
        with own_code(path, f"{cls.__name__}()"):
            return made(cls, path)
    except StretchError as error:
        raise TreeError([mark.error("import", str(error), "mend the class of the node")]) from error


def made(cls: type[Behavior], path: str) -> Behavior:
    """Return a node of this class; raises NodeError where its `__init__` or `__new__` leaves out what nodes are made of."""
    node = cls(path)
    if not isinstance(node, cls):
        raise NodeError(path, f"{cls.__name__}() gave {shown(node)}; its __new__ must return the node that it makes")
    missing = sorted(name for name in base_attributes() if not hasattr(node, name))
    if missing:
        hint = "begin its __init__ with super().__init__(path)"
        raise NodeError(path, f"{cls.__name__}() made a node without {missing[0]!r}; {hint}")
    return node


@cache
def base_attributes() -> frozenset[str]:
    """Return the attributes that every node has from its base."""
    return frozenset(vars(Behavior()))
