"""The end of every run: nodes and devices stopped, each `finally` run, whatever breaks on the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from py_trees.common import Status

from stretch_bt.break_off import BrokenOff
from stretch_bt.clock import EndOfRecord
from stretch_bt.errors import NodeError
from stretch_bt.runtime.cut_off import CutOff
from stretch_bt.runtime.foreign_nodes import shut_down
from stretch_bt.runtime.outcome import Outcome, reason_of, status_of
from stretch_bt.runtime.stop import failed_at, stop_tree
from stretch_bt.runtime.ticker import Ticker
from stretch_bt.tree.built_tree import BuiltTree, Node

__all__ = ["FINALLY_LIMIT", "SafeEnd", "Stoppable", "explained"]

#: how long `finally` may take, s of the run's clock
FINALLY_LIMIT = 60.0


class Stoppable(Protocol):
    """What is stopped at the end: the cell."""

    def stop(self) -> Sequence[Exception]:
        """Stop every device, and return what went wrong."""
        ...


class SafeEnd:
    """Ends a run in the same safe state, however its task ended.

    Parameters
    ----------
    tree
        What was ticked.
    ticker
        What ticked it, and ticks each `finally`.
    outcome
        How the task ended; an error here makes it worse.
    cell
        The devices, where there are any.
    """

    def __init__(self, tree: BuiltTree, ticker: Ticker, outcome: Outcome, cell: Stoppable | None) -> None:
        self._tree = tree
        self._ticker = ticker
        self._outcome = outcome
        self._cell = cell

    def run(self) -> None:
        """Leaves stopped in reverse, devices stopped, every `finally`, devices stopped again."""
        outcome, ticker, telling = self._outcome, self._ticker, self._ticker.telling
        telling.shield(outcome.errors)
        lost = ticker.mend()
        ticker.hearing.restore()
        abnormal = outcome.status not in ("SUCCESS", "FAILURE")
        telling.note("stop", status=outcome.status, reason=outcome.reason)
        owed = self._tree.take_pending()
        errors = [*lost, *self._stop_nodes(self._tree.root)]
        if abnormal or errors:
            errors += self._stop_devices()
        for finish in owed:
            errors += self._finally(finish)
        if self._tree.finish is not None:
            errors += self._finally(self._tree.finish)
        outcome.worsen_by(errors)  # before the last stop, which depends on how the run ended
        errors += self._stop_devices()
        errors += shut_down(self._tree)
        for error in errors:
            outcome.errors.append(reason_of(error))
            outcome.blame(error)
            telling.note("stop_error", error=type(error).__name__, reason=reason_of(error))
        outcome.worsen_by(errors)

    def _stop_nodes(self, root: Node) -> list[BaseException]:
        errors = [*stop_tree(root), *self._ticker.mend()]
        self._ticker.telling.interrupted()
        return errors

    def _stop_devices(self) -> list[BaseException]:
        if self._cell is None:
            return []
        try:
            return list(self._cell.stop())
        except BaseException as error:
            return [error]

    def _finally(self, finish: Node) -> list[BaseException]:
        """Tick a `finally` to its end or to one interrupt more than the task had, then the `finally` of each tree that it called and left.

        Returns the errors of stopping them.
        """
        self._tick_finally(finish)
        errors: list[BaseException] = [*self._ticker.mend()]
        owed = self._tree.take_pending(finish)
        errors += self._stop_nodes(finish)
        for inner in owed:
            errors += self._finally(inner)
        return errors

    def _tick_finally(self, finish: Node) -> None:
        name, ticker = finish.path.rpartition("/")[0], self._ticker
        if ticker.begin_finally() > 1:
            return self._unfinished(f"{name} was not run: stopped twice")
        until = ticker.context.now + FINALLY_LIMIT
        try:
            while (status := ticker.tick(finish)) is Status.RUNNING:
                if ticker.context.now >= until:
                    return self._unfinished(f"{name} did not end within {FINALLY_LIMIT:g} s")
            if status is None:
                self._cut_short(name)
            elif status is Status.FAILURE:
                self._unfinished(explained(finish, status))
        except (BrokenOff, CutOff) as error:
            self._cut_short(name, ticker.break_off(error))
        except EndOfRecord:
            pass
        except BaseException as error:
            cause = ticker.cause(error)
            self._outcome.blame(cause)
            at = "" if isinstance(cause, NodeError) else f"{ticker.at_work(name) or name}: "
            self._unfinished(at + reason_of(cause), status_of(cause))

    def _cut_short(self, name: str, cut: str = "") -> None:
        self._unfinished(f"{name} was cut short by {self._ticker.interrupts[-1]}{cut}", "INTERRUPTED")

    def _unfinished(self, reason: str, status: str = "FAILURE") -> None:
        self._outcome.finally_failed(reason, status)
        self._ticker.telling.note("finally", reason=reason)


def explained(root: Node, status: Status) -> str:
    """Return why a tree ended so: the node that failed, with its reason."""
    if status is Status.SUCCESS:
        return ""
    node = failed_at(root)
    return f"{node.path}: {node.feedback_message or 'failed'}"
