"""Stopping a tree so that every node that started is interrupted, whatever any of them does."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.common import Status

from stretch_bt.tree.built_tree import Node
from stretch_bt.tree.flow.base import failed_at

__all__ = ["failed_at", "started_leaves", "stop_tree"]


def started_leaves(root: Node) -> list[Node]:
    """Return the leaves that started and did not end, in the order of the tree; one that broke half way is among them."""
    leaves = (node for node in _all(root) if not node.children)
    return [leaf for leaf in leaves if leaf.status is Status.RUNNING or getattr(leaf, "active", False)]


def stop_tree(root: Node) -> list[BaseException]:
    """Interrupt the started leaves in reverse order, each error apart from the others, then mark the rest as ended.

    `terminate` of each is called once; nodes that had already ended are not called.
    """
    errors: list[BaseException] = []
    nodes = list(_all(root))  # what a node does to itself as it ends hides no other
    for leaf in reversed(started_leaves(root)):
        try:
            leaf.stop(Status.INVALID)
        except BaseException as error:  # a node that cannot stop must not keep the others from stopping
            errors.append(error)
    for node in nodes:
        node.status = Status.INVALID
    return errors


def _all(root: Node) -> Iterator[Node]:
    yield root
    for child in root.children:
        yield from _all(child)
