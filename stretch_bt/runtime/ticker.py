"""The loop of a run: waits for deadlines, ticks a tree, and hears interrupts meanwhile."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from py_trees.common import Status

from stretch_bt.break_off import BrokenOff, breakable
from stretch_bt.clock import Clock
from stretch_bt.errors import NodeError, StretchError
from stretch_bt.forked import alone, leave_if_forked
from stretch_bt.runtime.as_built import AsBuilt
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.cut_off import CutOff, Patience
from stretch_bt.runtime.hearing import Hearing
from stretch_bt.runtime.outcome import Outcome, reason_of
from stretch_bt.runtime.signals import signals
from stretch_bt.runtime.telling import Telling
from stretch_bt.runtime.tick_grid import TickGrid
from stretch_bt.runtime.watcher import Watcher
from stretch_bt.tree.built_tree import BuiltTree, Node

__all__ = ["Planned", "Ticker"]


class Planned(NamedTuple):
    """What interrupted the run of a record at once, and whether it came while nodes and devices were stopped."""

    why: Sequence[str]
    stopping: bool = False


class Ticker:
    """Ticks the task of a tree, and then what has to follow it.

    Parameters
    ----------
    tree, context, clock
        The tree to tick, the context that its nodes share, and the clock of the run.
    grid
        When ticks are due.
    outcome
        Where overruns and errors are kept.
    watchers
        Who gets the reports.
    planned
        Interrupts by the tick before which they come, in a replay: the groups that were noted, each with whether it came while
        nodes and devices were stopped.
    cuts
        Ticks in which a node was cut off, each with its path, in a replay.
    """

    def __init__(
        self,
        tree: BuiltTree,
        context: RunContext,
        clock: Clock,
        grid: TickGrid,
        outcome: Outcome,
        watchers: list[Watcher],
        planned: Mapping[int, Sequence[Planned]] | None = None,
        cuts: Mapping[int, str] | None = None,
    ) -> None:
        self.tree = tree
        self.context = context
        self.clock = clock
        self.grid = grid
        self.outcome = outcome
        self.telling = Telling(watchers, tree.nodes)
        self.planned = {tick: [*groups] for tick, groups in (planned or {}).items()}
        self._noted = 0
        self.interrupts: list[str] = []
        #: the interrupts that were not planned
        self.heard: list[str] = []
        #: how many interrupts there were before what goes on began: the task, or a `finally`
        self.limit = 0
        self._cuts = dict(cuts or {})
        self._patience = Patience(self._hurried, self._path_of)
        self._as_built = AsBuilt(tree)
        self.hearing = Hearing(tree.nodes)
        self._begun = False
        outcome.notes = self.hearing.notes

    # --- interrupts

    def interrupt(self, why: str) -> None:
        """Ask what goes on to stop; may be called from a signal handler or another thread."""
        self.interrupts.append(why)
        self.heard.append(why)
        self.clock.wake()
        self._patience.begin()

    @property
    def interrupted(self) -> bool:
        """Whether there were more interrupts than what goes on had before it began."""
        return len(self.interrupts) > self.limit

    def _hurried(self) -> bool:
        """Whether the running part is to stop: it was interrupted, or is in the record as cut off."""
        return self.interrupted or self.context.ticks in self._cuts

    @contextmanager
    def attended(self) -> Iterator[None]:
        """Hear signals, and cut off nodes that do not return after one, while the block runs."""
        with signals(self.interrupt), alone(), self._patience:
            yield

    def break_off(self, error: BrokenOff | CutOff) -> str:
        """Note what broke a tick off, and return the message about a node that was cut off in it."""
        self._take_planned()
        cut = self._cuts.pop(self.context.ticks, "")
        if isinstance(error, CutOff):
            cut = error.path
            self.outcome.blame(error)
        how: dict[str, Any] = {"cut_off": cut} if cut else {"broken_off": True}
        self._note_interrupts(**how)
        return f"; {CutOff(cut)}" if cut else ""

    def begin_finally(self) -> int:
        """Return how many interrupts there were before a `finally` begins; those that came while nodes and devices were stopped are noted."""
        self._take_planned(stopping=True)
        if len(self.interrupts) > self._noted:
            self._note_interrupts(stopping=True)
        self.limit = self._noted  # one that comes from now on ends the `finally`, and is noted then
        return self.limit

    def _take_planned(self, *, stopping: bool = False) -> None:
        """Take up what interrupted the run of a record next, before the tick that would follow."""
        groups = self.planned.get(self.grid.ticks + 1)
        if groups and groups[0].stopping == stopping:
            self.interrupts += groups.pop(0).why

    def _note_interrupts(self, **how: Any) -> None:
        why = self.interrupts[self._noted :]
        self._noted += len(why)
        self.telling.note("interrupt", why=why, **how)

    # --- ticks

    def begin(self) -> None:
        """Let the first tick be due now."""
        now = self.context.now = self.context.start = self.clock.now()
        self.grid.join(now)

    def follow(self) -> None:
        """Let what follows a stop not wait for the next tick."""
        self.grid.begin(self.clock.now())
        self._patience.begin()

    def tick(self, root: Node) -> Status | None:
        """Wait for the next deadline and tick once; None when it is interrupted before it."""
        self._take_planned()
        self._wait()
        if self.interrupted:
            self._note_interrupts()
            return None
        context = self.context
        context.ticks = self.grid.take()
        context.now = self.clock.now()
        if not self._begun:
            self._begun, context.start = True, context.now
        self.telling.begin_tick(context.ticks, context.now)
        if context.ticks in self._cuts:
            self._patience.begin()
        try:
            with breakable(lambda: self.interrupted):
                self.telling.visit(root)
        finally:
            leave_if_forked()  # whatever broke in the child, nothing of it is reported
            self.hearing.look()
            self.telling.interrupted()
            self._lateness()
        if root.status is Status.INVALID:
            raise NodeError(root.path, "the tree ended without a status")
        status: Status = root.status
        return status

    def _wait(self) -> None:
        while not self.interrupted:
            self.clock.wait_until(self.grid.due)
            if self.clock.reached(self.grid.due):
                break

    def _lateness(self) -> None:
        late = self.grid.leave(self.clock.now())
        if late > 0:
            self.outcome.overruns += 1
            self.outcome.worst_overrun = max(self.outcome.worst_overrun, late)
            self.telling.note("overrun", seconds=late)

    # --- what breaks in nodes

    def at_work(self, under: str = "") -> str:
        """Return the path of the innermost node whose code was running when an error came up."""
        paths = (path for path, node in self.tree.nodes.items() if getattr(node, "ticking", False))
        return next((path for path in paths if path.startswith(under)), "")

    def _path_of(self, node: Node) -> str:
        """Return the path of a node, or of the node of the tree that ticks it."""
        return next((path for path, known in self.tree.nodes.items() if known is node), "") or self.at_work()

    def mend(self) -> list[NodeError]:
        """Put back what nodes lost, without which the run does not come to its end, and return the errors about it."""
        lost = self._as_built.mend()
        self.telling.forget_lost()
        return lost

    def cause(self, error: BaseException) -> BaseException:
        """Return an error, or the error of a node that lost its attributes, so that something else of ours broke."""
        lost = self.mend()
        if not lost or isinstance(error, StretchError):
            self.outcome.errors += map(reason_of, lost)
            return error
        self.outcome.errors += map(reason_of, lost[1:])
        return lost[0]
