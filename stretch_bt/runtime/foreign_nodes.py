"""Behaviours of other packages in a run: set up before the first tick, shut down at its end, and a Blackboard that stays as it was."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy

from py_trees.blackboard import Blackboard, KeyMetaData

from stretch_bt.tree.build import BuiltTree

__all__ = ["kept_blackboard", "set_up", "shut_down"]


def set_up(tree: BuiltTree) -> None:
    """Call `setup` of each behaviour of another package, in the order of the tree; raises NodeError for the first that breaks."""
    for node in tree.foreign:
        node.setup()


def shut_down(tree: BuiltTree) -> list[BaseException]:
    """Call `shutdown` of each that was set up, the last one first, and return what broke: none keeps the others from it."""
    errors: list[BaseException] = []
    for node in reversed(tree.foreign):
        try:
            node.shutdown()
        except BaseException as error:
            errors.append(error)
    return errors


@contextmanager
def kept_blackboard(tree: BuiltTree) -> Iterator[None]:
    """Let the nodes of a run see what the Blackboard of py_trees holds, and leave it as it was: the next run begins afresh.

    It is one for the whole process. What a run changes inside a value, as by appending to a list, is not undone. A tree whose nodes use
    no Blackboard leaves alone what others write meanwhile.
    """
    if not tree.foreign and not any(getattr(node, "blackboards", ()) for node in tree.nodes.values()):
        yield
        return
    values, clients, stream = dict(Blackboard.storage), dict(Blackboard.clients), Blackboard.activity_stream
    about = {key: _copied(data) for key, data in Blackboard.metadata.items()}
    try:
        yield
    finally:
        # the tables stay the same objects, which clients and displays may hold
        for table, before in ((Blackboard.storage, values), (Blackboard.clients, clients), (Blackboard.metadata, about)):
            table.clear()
            table.update(before)  # type: ignore[attr-defined]
        Blackboard.activity_stream = stream


def _copied(data: KeyMetaData) -> KeyMetaData:
    """Return who reads and writes a key, which changes as clients come."""
    made = copy(data)
    made.read, made.write, made.exclusive = set(data.read), set(data.write), set(data.exclusive)
    return made
