"""Behaviours of other packages in a run: set up before the first tick, shut down at its end, and a Blackboard that stays as it was."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from copy import copy
from typing import TypeVar

from py_trees.blackboard import Blackboard, KeyMetaData

from stretch_bt.clock import Clock, PacedClock, VirtualClock
from stretch_bt.tree.built_tree import BuiltTree

__all__ = ["kept_blackboard", "kept_for", "paced_for", "set_up", "shut_down"]


K = TypeVar("K")
V = TypeVar("V")


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


def paced_for(tree: BuiltTree, clock: Clock) -> Clock:
    """Return a clock that goes no faster than the machine's for a tree with such behaviours, which count that; else the clock itself."""
    return PacedClock(clock) if tree.foreign and isinstance(clock, VirtualClock) else clock


def kept_for(tree: BuiltTree) -> AbstractContextManager[None]:
    """Keep the Blackboard for a tree with nodes that use it; a run without leaves alone what others write meanwhile."""
    uses = tree.foreign or any(getattr(node, "blackboards", ()) for node in tree.nodes.values())
    return kept_blackboard() if uses else nullcontext()


@contextmanager
def kept_blackboard() -> Iterator[None]:
    """Show what the Blackboard of py_trees holds, and leave it as it was: it is one for the process, and the next run begins afresh.

    What is changed inside a value, as by appending to a list, is not undone.
    """
    values, clients, stream = dict(Blackboard.storage), dict(Blackboard.clients), Blackboard.activity_stream
    about = {key: _copied(data) for key, data in Blackboard.metadata.items()}
    try:
        yield
    finally:
        # the tables stay the same objects, which clients and displays may hold
        _put_back(Blackboard.storage, values)
        _put_back(Blackboard.clients, clients)
        _put_back(Blackboard.metadata, about)
        Blackboard.activity_stream = stream


def _put_back(table: dict[K, V], before: dict[K, V]) -> None:
    table.clear()
    table.update(before)


def _copied(data: KeyMetaData) -> KeyMetaData:
    """Return who reads and writes a key, which changes as clients come."""
    made = copy(data)
    made.read, made.write, made.exclusive = set(data.read), set(data.write), set(data.exclusive)
    return made
