"""Stopping a tree so that every running node is told, whatever any of them does."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.common import Status

from stretch_bt.tree.build import Node

__all__ = ["failed_at", "running_leaves", "stop_tree"]


def running_leaves(root: Node) -> list[Node]:
    """Return the running nodes that have no running child, in the order of the tree."""

    def visit(node: Node) -> Iterator[Node]:
        inner = [leaf for child in node.children for leaf in visit(child)]
        if inner:
            yield from inner
        elif node.status is Status.RUNNING:
            yield node

    return list(visit(root))


def stop_tree(root: Node) -> list[Exception]:
    """Interrupt the running leaves in reverse order, each error apart from the others, then mark the rest as ended.

    `terminate` of each running leaf is called once; nodes that had already ended are not told again.
    """
    errors: list[Exception] = []
    for leaf in reversed(running_leaves(root)):
        try:
            leaf.stop(Status.INVALID)
        except Exception as error:  # a node that cannot stop must not keep the others from stopping
            errors.append(error)
    for node in _all(root):
        node.status = Status.INVALID
        node.iterator = node.tick()
    return errors


def _all(root: Node) -> Iterator[Node]:
    yield root
    for child in root.children:
        yield from _all(child)


def failed_at(root: Node) -> Node:
    """Return the node that made the tree fail: the last failed one, as deep as failures go."""
    node = root
    while True:
        failed = [child for child in node.children if child.status is Status.FAILURE]
        if not failed or node.feedback_message:
            return node
        node = failed[-1]
