"""Passes of a loop that has a bound, one start per tick."""

from __future__ import annotations

from collections.abc import Callable, Generator

import py_trees
from py_trees.common import Status

from stretch_bt.tree.flow.base import FlowNode, failed_pass
from stretch_bt.tree.flow.count import counted
from stretch_bt.tree.flow.passes import PassKeys

__all__ = ["CountedPasses"]


class CountedPasses(FlowNode):
    """Counts the passes of its child that end with `again`, up to a bound; `counter` is the loop's word for the bound."""

    def __init__(
        self,
        path: str,
        child: py_trees.behaviour.Behaviour,
        bound: Callable[[], int],
        counter: str,
        again: Status,
        keys: PassKeys,
    ) -> None:
        super().__init__(path, child)
        self.bound = bound
        self.counter = counter
        self.again = again
        self.keys = keys
        self.passes = 0
        self.most = 0

    def begin(self) -> None:
        """Count from the start, to a number that passes do not change."""
        self.passes = 0
        self.keys.begin()
        self.most = counted(self.bound, self.path, self.counter)

    def tick_pass(self) -> Generator[py_trees.behaviour.Behaviour, None, Status]:
        """Tick the child and return its status; a pass that ended with `again` is counted, any other failure explained."""
        if self.child.status is not Status.RUNNING:
            self.keys.start(self.passes)
        yield from self.child.tick()
        status: Status = self.child.status
        if status is self.again:
            self.passes += 1
            self.keys.end()
        elif status is Status.FAILURE:
            self.feedback_message = failed_pass(self.passes, self.child)
        return status
