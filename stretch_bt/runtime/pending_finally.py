"""Each `finally` that an interrupted subtree left undone: it belongs to the cell, and runs before anything there starts again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from py_trees.common import Status

from stretch_bt.clock import Clock, MixedClock, VirtualClock
from stretch_bt.errors import DeviceFault, StretchError
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.foreign_nodes import shut_down
from stretch_bt.runtime.safe_end import FINALLY_LIMIT
from stretch_bt.runtime.stop import stop_tree
from stretch_bt.tree.built_tree import BuiltTree, Node
from stretch_bt.tree.flow.base import why_failed

__all__ = ["FinallyTicker", "PendingFinally", "raise_besides", "worst_of"]


class FinallyTicker:
    """Ticks the `finally` of a tree and of the trees that it called, the innermost first and one after the other; each has a minute."""

    def __init__(self, built: BuiltTree, context: RunContext) -> None:
        self.built, self.context = built, context
        self._ahead: list[Node] = [*built.take_pending(), *([built.finish] if built.finish is not None else [])]
        self._began: float | None = None
        self.errors: list[BaseException] = []
        #: why one of them failed
        self.failed = ""

    @property
    def path(self) -> str:
        """Path of the one that is ticked, or was last."""
        return str(self._ahead[0].path).rpartition("/")[0] if self._ahead else "finally"

    def stop(self) -> list[BaseException]:
        """Stop the nodes of the one that is ticked, and return what broke; no other is ticked any more."""
        ahead, self._ahead = self._ahead, []
        return [*stop_tree(ahead[0])] if ahead else []

    def tick(self) -> bool:
        """Tick once, and return whether all have ended; exceptions are kept in `errors`."""
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
            why = "it did not end in time" if status is Status.RUNNING else "it failed"
            late = f"{finish.path}: {finish.feedback_message or why}"
            self.failed = self.failed or (why_failed(finish) if status is Status.FAILURE else late)
        self.errors += stop_tree(finish)
        self._ahead[:1] = self.built.take_pending(finish)
        self._began = None
        return False


class PendingFinally:
    """What the subtrees of a cell owe, one after the other, and what broke where nothing may be raised.

    Parameters
    ----------
    clock
        Clock of the cell.
    begin_tick
        Begins a tick of a tree with this context.
    stop
        Stops every device.
    """

    def __init__(
        self, clock: Clock, begin_tick: Callable[[RunContext], None], stop: Callable[[], Sequence[Exception]]
    ) -> None:
        self.clock = clock
        self.errors: list[BaseException] = []
        self._begin_tick = begin_tick
        self._stop = stop
        self._pending: list[tuple[FinallyTicker, float]] = []
        self._ticked = float("-inf")
        #: the signal that ended what is owed before its time, where one did
        self._cut = ""
        #: the time at which a tree that is attended began its tick
        self._attended: float | None = None

    def __bool__(self) -> bool:
        return bool(self._pending)

    @property
    def periods(self) -> list[float]:
        """Tick periods of what is owed, s."""
        return [period for _, period in self._pending]

    def add(self, ticker: FinallyTicker, period: float) -> None:
        """Owe the `finally` of a tree that was interrupted."""
        self._pending.append((ticker, period))
        self._ticked = max(self._ticked, ticker.context.now)

    def attend(self, _: Any = None) -> None:
        """Begin a tick of a tree that is attended; raises DeviceFault once every device is stopped."""
        self.tick()
        self._attended = self.clock.now()
        fault = next((error for error in self.errors if isinstance(error, DeviceFault)), None)
        if fault is not None:
            self.errors.remove(fault)
            raise fault

    def leave(self, _: Any = None) -> None:
        """End a tick of a tree that is attended."""
        self._attended = None

    def tick_unattended(self) -> None:
        """Tick for a tree that is not attended, which somebody else may be in this very tick."""
        if self._attended is None or self._attended != self.clock.now():
            self.tick()

    def tick(self) -> None:
        """Tick the first owed `finally` once; at an exception every device is stopped."""
        if not self._pending:
            return
        ticker, period = self._pending[0]
        if isinstance(self.clock, VirtualClock) and self.clock.now() <= self._ticked:
            self.clock.advance(period)
        elif isinstance(self.clock, MixedClock):
            self.clock.follow(period)
        self._ticked = self.clock.now()
        try:
            self._begin_tick(ticker.context)
        except Exception as error:  # a record that cannot be written keeps no hand from being raised
            self.errors.append(error)
        before = len(ticker.errors)
        done = ticker.tick()
        if len(ticker.errors) > before:
            self.errors += [*ticker.errors[before:], *self._stop()]
        if done:
            self._pending.pop(0)
            self.errors += shut_down(ticker.built)
            if ticker.failed and not ticker.errors:
                self.errors.append(StretchError(f"a finally failed: {ticker.failed}"))

    def cut_short(self, name: str) -> None:
        """Owe nothing from the next tick on, because of a signal; a second one breaks off a node that does not end.

        Raises
        ------
        KeyboardInterrupt
            It is the second.
        """
        if self._cut:
            raise KeyboardInterrupt(name)
        self._cut = name

    def settle(self) -> None:
        """Tick all of it to its end, or to a signal, at which every device is stopped."""
        while self._pending:
            if self._cut:
                paths = ", ".join(ticker.path for ticker, _ in self._pending)
                self.errors += [StretchError(f"{paths}: cut short by {self._cut}"), *self._stop()]
                for ticker, _ in self._pending:
                    self.errors += [*ticker.stop(), *shut_down(ticker.built)]
                self._pending.clear()
                return
            if not isinstance(self.clock, VirtualClock):
                self.clock.wait_until(self.clock.now() + self._pending[0][1])
            self.tick()

    def take_errors(self) -> list[BaseException]:
        """Return what broke since this was asked last."""
        errors, self.errors = self.errors, []
        return errors


def raise_besides(raised: Sequence[BaseException], errors: Sequence[BaseException]) -> None:
    """Raise the worst of what is raised already, one or none, and of errors since; a signal stays one, with them as its notes."""
    if not errors:
        return
    if raised and isinstance(raised[0], KeyboardInterrupt):
        for error in errors:
            raised[0].add_note(str(error))
        return
    worst = worst_of([*raised, *errors])
    if worst not in raised:
        raise worst


def worst_of(errors: Sequence[BaseException]) -> BaseException:
    """Return the error to raise of several: a fault of a device before any other, with what else broke as its notes."""
    worst = next((error for error in errors if isinstance(error, DeviceFault)), errors[0])
    for error in errors:
        if error is not worst:
            worst.add_note(f"besides: {error}")
    return worst
