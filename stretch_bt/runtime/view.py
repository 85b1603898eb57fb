"""Whoever shows a run while it goes on, and how it is kept from ending one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from py_trees.common import Status

from stretch_bt.errors import named
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.tree.built_tree import BuiltTree

__all__ = ["Shown", "View"]


class View(Protocol):
    """Who shows a run while it goes on."""

    def start(self, outline: list[tuple[int, str, str]]) -> None:
        """Begin to show a tree."""
        ...

    def update(self, now: float, statuses: Mapping[str, tuple[str, str]]) -> None:
        """Show the task time, s, and by path the status of nodes and what they are doing."""
        ...

    def stop(self) -> None:
        """End."""
        ...


class Shown(Onlooker):
    """Reports every change to a view, and at each tick the reasons that the running nodes give.

    A view that breaks is left alone from then on: the task goes on. `errors` says why, unless its terminal is gone.
    """

    def __init__(self, view: View, built: BuiltTree) -> None:
        self.view = view
        self.built = built
        self.now = 0.0
        self.broken = False
        self.errors: list[str] = []

    def start(self) -> None:
        """Begin to show the tree."""
        self._try(lambda: self.view.start(self.built.outline()))

    def stop(self) -> None:
        """End, also where the view broke before: it may have a terminal to put back."""
        self.broken = False
        self._try(self.view.stop)

    def begin_tick(self, tick: int, time: float) -> None:
        """Show the time, and what runs."""
        self.now = time
        nodes = self.built.nodes.items()
        self._show({p: (n.status.name, n.feedback_message) for p, n in nodes if n.status is Status.RUNNING})

    def status(self, path: str, status: str, reason: str = "") -> None:
        """Show a change."""
        self._show({path: (status, reason)})

    def _show(self, statuses: Mapping[str, tuple[str, str]]) -> None:
        self._try(lambda: self.view.update(self.now, statuses))

    def _try(self, action: Callable[[], None]) -> None:
        if self.broken:
            return
        try:
            action()
        except (OSError, SystemExit):  # rich turns a closed pipe into SystemExit
            self.broken = True
        except Exception as error:
            self.broken = True
            self.errors.append(f"the view broke ({named(error)})")
