"""Each `finally` that an interrupted subtree left undone: it belongs to the cell, and runs before anything there starts again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.common import Status

from stretch_bt.clock import Clock, MixedClock, VirtualClock
from stretch_bt.errors import named
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.foreign_nodes import shut_down
from stretch_bt.runtime.runner import FINALLY_LIMIT
from stretch_bt.runtime.stop import stop_tree
from stretch_bt.tree.build import BuiltTree, Node

__all__ = ["Finals", "Owed", "take_finals"]


def take_finals(built: BuiltTree) -> list[Node]:
    """Return every `finally` that a tree owes, the innermost first."""
    return [*built.take_pending(), *([built.finish] if built.finish is not None else [])]


class Finals:
    """Ticks the `finally` of a tree and of those that it called, one after the other; each has a minute."""

    def __init__(self, built: BuiltTree, context: RunContext) -> None:
        self.built, self.context = built, context
        self._ahead = take_finals(built)
        self._began: float | None = None
        self.errors: list[BaseException] = []
        #: why one of them failed
        self.failed = ""

    def tick(self) -> bool:
        """Tick once, and return whether all have ended; what breaks is kept in `errors`."""
        while self._ahead:
            if self._tick_first(self._ahead[0]):
                return False
        return True

    def _tick_first(self, finish: Node) -> bool:
        """Tick one, and return whether it goes on."""
        now = self.context.now
        self._began = now if self._began is None else self._began
        try:
            for _ in finish.tick():
                pass
            status = finish.status
        except BaseException as error:  # the next one is due all the same
            self.errors.append(error)
            status = Status.INVALID
        if status is Status.RUNNING and now - self._began < FINALLY_LIMIT:
            return True
        if status is not Status.SUCCESS:
            self.failed = self.failed or f"{finish.path}: {finish.feedback_message or 'it did not end in time'}"
        self.errors += stop_tree(finish)
        self._ahead[:1] = self.built.take_pending(finish)
        self._began = None
        return False


class Owed:
    """What the subtrees of a cell owe, and what broke where nothing may be raised."""

    def __init__(self, clock: Clock, tick: Callable[[RunContext], None]) -> None:
        self.clock = clock
        #: whether a behaviour tree ticks them, so that subtrees need not
        self.attended = False
        self.errors: list[BaseException] = []
        self._tick = tick
        self._finals: list[tuple[Finals, float]] = []
        self._ticked = float("-inf")

    def __bool__(self) -> bool:
        return bool(self._finals)

    def add(self, finals: Finals, period: float) -> None:
        """Owe the `finally` of a tree that was interrupted."""
        self._finals.append((finals, period))
        self._ticked = max(self._ticked, finals.context.now)

    def tick(self, _: Any = None) -> None:
        """Tick what is owed once."""
        if not self._finals:
            return
        period = min(period for _, period in self._finals)
        if isinstance(self.clock, VirtualClock) and self.clock.now() <= self._ticked:
            self.clock.advance(period)
        elif isinstance(self.clock, MixedClock):
            self.clock.follow(period)
        self._ticked = self.clock.now()
        for entry in list(self._finals):
            finals, _ = entry
            self._tick(finals.context)
            if finals.tick():
                self._finals.remove(entry)
                self.errors += [*finals.errors, *shut_down(finals.built)]
                if finals.failed and not finals.errors:
                    self.errors.append(RuntimeError(f"a finally failed: {finals.failed}"))

    def settle(self) -> None:
        """Tick all of it to its end."""
        while self._finals:
            period = min(period for _, period in self._finals)
            if not isinstance(self.clock, VirtualClock):
                self.clock.wait_until(self.clock.now() + period)
            self.tick()

    def take_errors(self) -> list[BaseException]:
        """Return what broke since this was asked last."""
        errors, self.errors = self.errors, []
        return errors


def told(errors: list[BaseException]) -> str:
    """Return what broke, in one line."""
    return "; ".join(named(error) for error in errors)
