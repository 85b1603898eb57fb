"""What a run reports to its watchers: which node came to which status, which key was written, and what else happened."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from py_trees.common import Status

from stretch_bt.runtime.watcher import Careful, Watcher
from stretch_bt.tree.built_tree import Node
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.flow.passes import PassKeys

__all__ = ["Telling"]

_NEVER = (Status.INVALID, -1)


class Telling:
    """Reports to the watchers of a run, each change of a status once.

    Parameters
    ----------
    watchers
        Who gets the reports, in this order.
    nodes
        Nodes of the tree, by path.
    """

    def __init__(self, watchers: list[Watcher], nodes: Mapping[str, Node]) -> None:
        self.watchers = watchers
        self._nodes = nodes
        self._passes = {path: found for path, node in nodes.items() if (found := _passes_around(node))}
        self._last: dict[str, tuple[Status, int]] = {}
        self._running: set[str] = set()

    def begin_tick(self, tick: int, time: float) -> None:
        """A tick begins, at `time`, s."""
        for watcher in self.watchers:
            watcher.begin_tick(tick, time)

    def visit(self, root: Node) -> None:
        """Tick a tree, and report each node that it comes to."""
        for node in root.tick():
            if node.status is not Status.RUNNING or self._last.get(node.path, _NEVER)[0] is not Status.RUNNING:
                self._changed(node)

    def interrupted(self) -> None:
        """Report nodes that were running and have been interrupted since."""
        for path in sorted(self._running):
            node = self._nodes[path]
            if node.status is Status.INVALID:
                self._tell(node, (Status.INVALID, 0))

    def written(self, cell: Cell) -> None:
        """A key was written, or left without a value."""
        value = None if cell.value is MISSING else cell.value
        for watcher in self.watchers:
            watcher.write(cell.name, value, cell.sd, cell.writer)

    def note(self, kind: str, **fields: Any) -> None:
        """Anything else happened."""
        for watcher in self.watchers:
            watcher.note(kind, **fields)

    def shield(self, errors: list[str]) -> None:
        """From now on no watcher that breaks may hold up the safe end; its exception goes to `errors`."""
        self.watchers = [w if isinstance(w, Careful) else Careful(w, errors) for w in self.watchers]

    def forget_lost(self) -> None:
        """Leave out nodes that the tree no longer has."""
        self._running &= self._nodes.keys()

    def _changed(self, node: Node) -> None:
        """Report a new status of a node, or one more end of it; for a condition, which is asked at each tick, only in another pass."""
        counts = getattr(node, "kind", "condition") != "condition"
        begun = node.runs if counts else sum(keys.begun for keys in self._passes.get(node.path, ()))
        state = (node.status, begun)
        if self._last.get(node.path) != state:
            self._tell(node, state)

    def _tell(self, node: Node, state: tuple[Status, int]) -> None:
        self._last[node.path] = state
        (self._running.add if node.status is Status.RUNNING else self._running.discard)(node.path)
        for watcher in self.watchers:
            watcher.status(node.path, node.status.name, node.feedback_message)


def _passes_around(node: Node) -> list[PassKeys]:
    """Return what counts the passes of each loop around a node."""
    found = []
    while (node := node.parent) is not None:
        if isinstance(keys := getattr(node, "keys", None), PassKeys):
            found.append(keys)
    return found
