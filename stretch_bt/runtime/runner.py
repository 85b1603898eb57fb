"""The runner: one tree, ticked on deadlines to its end, and then stopped safely."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from py_trees.common import Status

from stretch_bt.break_off import BrokenOff
from stretch_bt.clock import Clock, EndOfRecord
from stretch_bt.errors import InvalidInput, NodeError
from stretch_bt.quantity_text import format_duration
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.cut_off import CutOff
from stretch_bt.runtime.foreign_nodes import set_up
from stretch_bt.runtime.outcome import Outcome, reason_of, status_of
from stretch_bt.runtime.safe_end import SafeEnd, Stoppable, explained
from stretch_bt.runtime.tick_grid import TickGrid
from stretch_bt.runtime.ticker import Planned, Ticker
from stretch_bt.runtime.watcher import Watcher
from stretch_bt.tree.built_tree import BuiltTree

__all__ = ["LONGEST", "Runner"]

#: after how much virtual time a task is ended, s, unless its caller says otherwise: nobody waits, so nobody would notice
LONGEST = 7200.0


class Runner:
    """Runs one built tree once: `run` at a stretch, or as a test does `begin`, `step` by step and `finish`, the last two within `attended`.

    `interrupt` may be called from a signal handler or another thread; the first call stops the task at once and safely,
    a second one also cuts `finally` short, as does the first when it comes during `finally`.
    """

    def __init__(
        self,
        tree: BuiltTree,
        context: RunContext,
        clock: Clock,
        *,
        period: float,
        cell: Stoppable | None = None,
        watchers: list[Watcher] | None = None,
        max_ticks: int | None = None,
        longest: float = math.inf,
        interrupts: Mapping[int, Sequence[Planned]] | None = None,
        cuts: Mapping[int, str] | None = None,
        grid: TickGrid | None = None,
    ) -> None:
        self.tree = tree
        self.context = context
        self.clock = clock
        self.cell = cell
        self.context.period = period
        #: the error that ended the task, if any
        self.cause: BaseException | None = None
        self.outcome = Outcome()
        grid = grid or TickGrid(period)
        self.ticker = Ticker(tree, context, clock, grid, self.outcome, watchers or [], interrupts, cuts)
        self._end = SafeEnd(tree, self.ticker, self.outcome, cell)
        self._max_ticks = max_ticks
        self._longest = longest
        self._is_set_up = False
        self._began = (0.0, 0.0)  # on the machine's clock, and CPU time
        self._used = threading.Lock()
        if tree.taken:
            raise InvalidInput("this tree has a runner already; build a new tree for a new run")
        tree.taken = True
        for cell_ in tree.cells:
            cell_.listener = self.ticker.telling.written

    # --- from outside

    def interrupt(self, why: str) -> None:
        """Ask for a safe stop."""
        self.ticker.interrupt(why)

    @property
    def watchers(self) -> list[Watcher]:
        """Who follows the run; one may be added before the first tick."""
        return self.ticker.telling.watchers

    @property
    def interrupted_by(self) -> tuple[str, ...]:
        """What asked for a safe stop so far, the first one first."""
        return tuple(self.ticker.interrupts)

    @property
    def unheard(self) -> list[str]:
        """Signals that came too late to end the task: in its last tick, or while the devices were stopped."""
        return [] if self.outcome.status == "INTERRUPTED" else list(self.ticker.interrupts)

    @property
    def deadline(self) -> float:
        """When the next tick is due, s."""
        return self.ticker.grid.due

    def run(self) -> Outcome:
        """Tick to the end, stop safely, and return how it ended; raises only when it is called twice."""
        self.begin()
        with self.attended():
            while self.step():
                pass
            return self.finish()

    def begin(self) -> None:
        """Take the time from which the ticks count; raises when the tree was run before."""
        if not self._used.acquire(blocking=False):
            raise RuntimeError("a runner runs its tree once; build a new tree for a new run")
        self._began = time.perf_counter(), time.process_time()
        self.ticker.begin()

    @contextmanager
    def attended(self) -> Iterator[None]:
        """Hear signals, and cut off nodes that do not return after one, while the block runs."""
        with self.ticker.attended():
            yield

    def step(self) -> bool:
        """Wait for the next tick of the task and do it; return whether the task goes on, else `outcome` says why it ended."""
        try:
            self._set_up()
            status = self.ticker.tick(self.tree.root)
            if status is None:
                self._stopped()
            elif status is not Status.RUNNING:
                self.outcome.end(status.name, explained(self.tree.root, status))
            elif self._max_ticks is not None and self.context.ticks >= self._max_ticks:
                self.outcome.end("FAILURE", f"no end after {self._max_ticks} ticks")
            elif self.context.time >= self._longest:
                self.outcome.end("FAILURE", _no_end(self._longest))
            else:
                return True
        except EndOfRecord:
            self.outcome.end("INTERRUPTED", "the record ends here")
        except (BrokenOff, CutOff) as error:
            cut = self.ticker.break_off(error)
            self._stopped()
            self.outcome.reason += cut
        except BaseException as error:  # a node must not end the program with its devices moving
            self._failed(error)
        return False

    def finish(self) -> Outcome:
        """Stop safely after the last step, and return how the run ended."""
        self._end.run()
        outcome = self.outcome
        outcome.task_seconds = self.context.time
        outcome.ticks = self.context.ticks
        outcome.wall_seconds = time.perf_counter() - self._began[0]
        outcome.cpu_seconds = time.process_time() - self._began[1]
        return outcome

    # --- the task

    def _set_up(self) -> None:
        if self._is_set_up:
            return
        self._is_set_up = True
        if not self.ticker.interrupted:
            set_up(self.tree)
        self.ticker.begin()  # the time of the setup is no time of the task

    def _stopped(self) -> None:
        """End by a signal."""
        self.ticker.follow()
        self.outcome.end("INTERRUPTED", f"stopped by {self.ticker.interrupts[0]}")

    def _failed(self, error: BaseException) -> None:
        ticker, outcome = self.ticker, self.outcome
        ticker.telling.shield(outcome.errors)
        self.cause = error = ticker.cause(error)
        reason = reason_of(error)
        if not isinstance(error, NodeError):
            at = ticker.at_work()
            reason = f"{at}: {reason}" if at else reason
        outcome.blame(error)
        outcome.end(status_of(error), reason)
        ticker.telling.note("error", error=type(error).__name__, reason=reason)


def _no_end(longest: float) -> str:
    within = format_duration(longest)
    return f"no end within {within} of virtual time; end it with a 'timeout', or let it take longer (`--longest`)"
