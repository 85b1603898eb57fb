"""Keeping the signals of a run heard, whatever its nodes do with handlers and masks."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from typing import Any

from py_trees.common import Status

from stretch_bt.runtime.signals import put_back
from stretch_bt.tree.behavior import Behavior

__all__ = ["Hearing"]

#: time between two looks, s of the machine's clock; one takes some microseconds
EVERY = 0.05
_SHIPPED = __name__.partition(".")[0] + "."


class Hearing:
    """Takes the signals of a run back where a node took them away, and says once which node it was.

    Parameters
    ----------
    nodes
        Nodes of the tree, by path. Without own ones among them nothing is done; neither is it outside the main thread.
    """

    def __init__(self, nodes: Mapping[str, Any]) -> None:
        self._own = {path: node for path, node in nodes.items() if _is_own(node)}
        #: how often each had started, and whether it ran, at the last look
        self._before = dict.fromkeys(self._own, (0, False))
        self._next = 0.0
        self.notes: list[str] = []

    def look(self) -> None:
        """Look whether signals are heard, unless that was done a moment ago; to be called after every tick."""
        if self._own and time.monotonic() >= self._next:
            self.restore()

    def restore(self) -> None:
        """Let signals be heard from now on."""
        if not self._own or threading.current_thread() is not threading.main_thread():
            return
        lost = put_back()
        if lost and not self.notes:
            self.notes.append(_told(lost, self._at_work()))
        self._before = {path: _state(node) for path, node in self._own.items()}
        if not self.notes:  # a node that did it once may do it on each tick
            self._next = time.monotonic() + EVERY

    def _at_work(self) -> list[str]:
        """Return the own nodes that were ticked since the last look."""
        now = {path: _state(node) for path, node in self._own.items()}
        return [path for path, before in self._before.items() if before[1] or now[path][1] or now[path] != before]


def _state(node: Behavior) -> tuple[int, bool]:
    return node.runs, node.status is Status.RUNNING


def _is_own(node: Any) -> bool:
    return isinstance(node, Behavior) and not type(node).__module__.startswith(_SHIPPED)


def _told(lost: list[str], nodes: list[str]) -> str:
    by = nodes[0] if len(nodes) == 1 else f"one of {', '.join(nodes or ['the nodes'])}"
    what = "them" if len(lost) > 1 else "it"
    return f"warning: {by} set a handler of {', '.join(lost)} or blocked {what}; the run took {what} back, for a stop must be heard"
