"""The runner: ticks on absolute deadlines, one thread, and a stop that always ends in the same safe state."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol

from py_trees.common import Status

from stretch_bt.blame import Broken, blame
from stretch_bt.break_off import BrokenOff, breakable
from stretch_bt.clock import Clock, EndOfRecord
from stretch_bt.errors import DeviceFault, InvalidInput, NodeError, StretchError, named, writable
from stretch_bt.forked import alone, leave_if_forked
from stretch_bt.runtime.as_built import AsBuilt
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.cut_off import CutOff, Patience
from stretch_bt.runtime.foreign_nodes import set_up, shut_down
from stretch_bt.runtime.hearing import Hearing
from stretch_bt.runtime.signals import signals
from stretch_bt.runtime.stop import failed_at, stop_tree
from stretch_bt.runtime.telling import Telling
from stretch_bt.runtime.watcher import Watcher
from stretch_bt.tree.build import BuiltTree, Node

__all__ = ["LONGEST", "Outcome", "Runner", "Stoppable", "Watcher"]

#: how long `finally` may take, s of the run's clock
FINALLY_LIMIT = 60.0
#: after how much virtual time a task is ended, s, unless its caller says otherwise: nobody waits, so nobody would notice
LONGEST = 7200.0


class Stoppable(Protocol):
    """What the runner stops at the end: the cell."""

    def stop(self) -> Sequence[Exception]:
        """Stop every device, and return what went wrong."""
        ...


@dataclass(slots=True)
class Outcome:
    """How a run ended."""

    status: str = "ERROR"
    reason: str = ""
    ticks: int = 0
    task_seconds: float = 0.0
    wall_seconds: float = 0.0
    cpu_seconds: float = 0.0
    overruns: int = 0
    worst_overrun: float = 0.0
    errors: list[str] = field(default_factory=list)
    broken: list[Broken] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


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
        interrupts: Mapping[int, Sequence[str]] | None = None,
        cuts: Mapping[int, str] | None = None,
    ) -> None:
        self.tree = tree
        self.context = context
        self.clock = clock
        self.period = context.period = period
        self.cell = cell
        self._telling = Telling(watchers or [], tree.nodes)
        self.max_ticks = max_ticks
        self._longest = longest
        self._first = context.ticks
        #: what ended the task, where it was an error
        self.cause: BaseException | None = None
        self.outcome = Outcome()
        self._planned = dict(interrupts or {})
        self._interrupts: list[str] = []
        #: how many interrupts there were before what goes on began: the task, or a `finally`
        self._limit = 0
        self._cuts = dict(cuts or {})
        self._patience = Patience(self._hurried, self._path_of)
        self._as_built = AsBuilt(tree)
        self._hearing = Hearing(tree.nodes)
        self.outcome.notes = self._hearing.notes
        self._origin, self._slot = 0.0, 0
        self._began = (0.0, 0.0)  # on the machine's clock, and CPU time
        self._used = threading.Lock()
        if tree.taken:
            raise InvalidInput("this tree has a runner already; build a new tree for a new run")
        tree.taken = True
        for cell_ in tree.cells:
            cell_.listener = self._telling.written

    # --- from outside

    def interrupt(self, why: str) -> None:
        """Ask for a safe stop."""
        self._interrupts.append(why)
        self.clock.wake()
        self._patience.begin()

    @property
    def watchers(self) -> list[Watcher]:
        """Who follows the run; one may be added before the first tick."""
        return self._telling.watchers

    @property
    def interrupted_by(self) -> tuple[str, ...]:
        """What asked for a safe stop so far, the first one first."""
        return tuple(self._interrupts)

    @property
    def unheard(self) -> list[str]:
        """Signals that came too late to end the task: in its last tick, or while the devices were stopped."""
        return [] if self.outcome.status == "INTERRUPTED" else list(self._interrupts)

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
        self._begin()

    @contextmanager
    def attended(self) -> Iterator[None]:
        """Hear signals, and cut off nodes that do not return after one, while the block runs."""
        with signals(self.interrupt), alone(), self._patience:
            yield

    def step(self) -> bool:
        """Wait for the next tick of the task and do it; return whether the task goes on, else `outcome` says why it ended."""
        try:
            if self.context.ticks == self._first:
                self._set_up()
            status = self._tick(self.tree.root)
            if status is None:
                self._stopped()
            elif status is not Status.RUNNING:
                self._end(status.name, self._explain(self.tree.root, status))
            elif self.max_ticks is not None and self.context.ticks >= self.max_ticks:
                self._end("FAILURE", f"no end after {self.max_ticks} ticks")
            elif self.context.time >= self._longest:
                self._end("FAILURE", _no_end(self._longest))
            else:
                return True
        except EndOfRecord:
            self._end("INTERRUPTED", "the record ends here")
        except (BrokenOff, CutOff) as error:
            cut = self._broken_off(error)
            self._stopped()
            self.outcome.reason += cut
        except BaseException as error:  # a node must not end the program with its devices moving
            self._failed(error)
        return False

    def finish(self) -> Outcome:
        """Stop safely after the last step, and return how the run ended."""
        self._stop_all()
        outcome = self.outcome
        outcome.task_seconds = self.context.time
        outcome.ticks = self.context.ticks
        outcome.wall_seconds = time.perf_counter() - self._began[0]
        outcome.cpu_seconds = time.process_time() - self._began[1]
        return outcome

    # --- ticking

    def _set_up(self) -> None:
        if not self._interrupted:
            set_up(self.tree)
        self._begin()  # what that took is no time of the task

    def _begin(self) -> None:
        self._origin = self.context.now = self.context.start = self.clock.now()

    def _stopped(self) -> None:
        """End by a signal; what follows a stop does not wait for the next tick."""
        self._origin, self._slot = self.clock.now(), 0
        self._patience.begin()
        self._end("INTERRUPTED", f"stopped by {self._interrupts[0]}")

    @property
    def _interrupted(self) -> bool:
        """Whether there were more interrupts than what goes on had before it began."""
        return len(self._interrupts) > self._limit

    def _hurried(self) -> bool:
        """Whether what goes on is to stop: it was interrupted, or is in the record as cut off."""
        return self._interrupted or self.context.ticks in self._cuts

    def _broken_off(self, error: BaseException) -> str:
        """Note by what a tick was broken off, and return what is told of a node that was cut off in it."""
        self._interrupts += self._planned.pop(self.context.ticks + 1, ())
        cut = self._cuts.pop(self.context.ticks, "")
        if isinstance(error, CutOff):
            cut = error.path
            self._blame(error)
        how: dict[str, Any] = {"cut_off": cut} if cut else {"broken_off": True}
        self._telling.note("interrupt", why=self._interrupts[self._limit :], **how)
        return f"; {CutOff(cut)}" if cut else ""

    def _path_of(self, node: Node) -> str:
        """Return the path of a node, or of that of the tree which ticks it."""
        return next((path for path, known in self.tree.nodes.items() if known is node), "") or self._ticking()

    def _tick(self, root: Node) -> Status | None:
        """Wait for the next deadline and tick once; None when it is interrupted before it."""
        self._interrupts += self._planned.pop(self.context.ticks + 1, ())
        self._wait()
        if self._interrupted:
            self._telling.note("interrupt", why=self._interrupts[self._limit :])
            return None
        context = self.context
        context.ticks += 1
        context.now = self.clock.now()
        if context.ticks == 1:
            context.start = context.now
        self._telling.begin_tick(context.ticks, context.now)
        if context.ticks in self._cuts:
            self._patience.begin()
        try:
            with breakable(lambda: self._interrupted):
                self._telling.visit(root)
        finally:
            leave_if_forked()  # whatever broke in the child, nothing of it is told
            self._hearing.look()
            self._telling.interrupted()
            self._lateness()
        if root.status is Status.INVALID:
            raise NodeError(root.path, "the tree ended without a status")
        status: Status = root.status
        return status

    @property
    def deadline(self) -> float:
        """When the next tick is due, s; not a sum, whose rounding grows."""
        return self._origin + self._slot * self.period

    def _wait(self) -> None:
        while not self._interrupted:
            self.clock.wait_until(self.deadline)
            if self.clock.reached(self.deadline):
                break

    def _lateness(self) -> None:
        """Set the next deadline on the grid of the period; a tick that ran past it is counted, not caught up with."""
        self._slot += 1
        late = self.clock.now() - self.deadline
        if late > 0 and self.period > 0:
            self.outcome.overruns += 1
            self.outcome.worst_overrun = max(self.outcome.worst_overrun, late)
            self._telling.note("overrun", seconds=late)
            self._slot += int(late / self.period + 1)

    # --- ending

    def _end(self, status: str, reason: str) -> None:
        self.outcome.status, self.outcome.reason = status, reason

    def _failed(self, error: BaseException) -> None:
        self._telling.shield(self.outcome.errors)
        self.cause = error = self._cause(error)
        status, reason = _kind(error), _told(error)
        if not isinstance(error, NodeError):
            at = self._ticking()
            reason = f"{at}: {reason}" if at else reason
        self._blame(error)
        self._end(status, reason)
        self._telling.note("error", error=type(error).__name__, reason=reason)

    def _cause(self, error: BaseException) -> BaseException:
        """Return an error, or that of a node which lost what it is made of, so that something else of ours broke."""
        lost = self._mended()
        if not lost or isinstance(error, StretchError):
            self.outcome.errors += map(_told, lost)
            return error
        self.outcome.errors += map(_told, lost[1:])
        return lost[0]

    def _mended(self) -> list[NodeError]:
        """Put back what nodes lost, without which the run does not come to its end, and return what is said of them."""
        lost = self._as_built.mend()
        self._telling.forget_lost()
        return lost

    def _blame(self, error: BaseException) -> None:
        found = blame(error)
        if found is not None:
            self.outcome.broken.append(found)

    def _ticking(self, under: str = "") -> str:
        """Return the path of the innermost node whose code was running when an error came up."""
        paths = (path for path, node in self.tree.nodes.items() if getattr(node, "ticking", False))
        return next((path for path in paths if path.startswith(under)), "")

    def _explain(self, root: Node, status: Status) -> str:
        if status is Status.SUCCESS:
            return ""
        node = failed_at(root)
        return f"{node.path}: {node.feedback_message or 'failed'}"

    def _stop_all(self) -> None:
        """Leaves stopped in reverse, devices stopped, every `finally`, devices stopped again."""
        self._telling.shield(self.outcome.errors)
        lost = self._mended()
        self._hearing.restore()
        abnormal = self.outcome.status not in ("SUCCESS", "FAILURE")
        self._telling.note("stop", status=self.outcome.status, reason=self.outcome.reason)
        owed = self.tree.take_pending()
        errors = [*lost, *self._stop_nodes(self.tree.root)]
        if abnormal or errors:
            errors += self._stop_devices()
        for finish in owed:
            errors += self._finally(finish)
        if self.tree.finish is not None:
            errors += self._finally(self.tree.finish)
        self._worse_by(errors)  # before the last stop: what is stopped depends on how the run ended
        errors += self._stop_devices()
        errors += shut_down(self.tree)
        for error in errors:
            self.outcome.errors.append(_told(error))
            self._blame(error)
            self._telling.note("stop_error", error=type(error).__name__, reason=_told(error))
        self._worse_by(errors)

    def _worse_by(self, errors: Sequence[BaseException]) -> None:
        """End as the worst of some errors says, where the task itself came to an end."""
        worst = next((e for e in errors if isinstance(e, DeviceFault)), errors[0] if errors else None)
        if worst is not None:
            self._worse(_kind(worst), _told(worst))

    def _stop_nodes(self, root: Node) -> list[BaseException]:
        errors = [*stop_tree(root), *self._mended()]
        self._telling.interrupted()
        return errors

    def _stop_devices(self) -> list[BaseException]:
        if self.cell is None:
            return []
        try:
            return list(self.cell.stop())
        except BaseException as error:
            return [error]

    def _finally(self, finish: Node) -> list[BaseException]:
        """Tick a `finally` to its end or to one interrupt more than the task had, then those of trees that it called and left.

        Returns what broke while stopping them.
        """
        self._tick_finally(finish)
        errors: list[BaseException] = [*self._mended()]
        owed = self.tree.take_pending(finish)
        errors += self._stop_nodes(finish)
        for inner in owed:
            errors += self._finally(inner)
        return errors

    def _tick_finally(self, finish: Node) -> None:
        name = finish.path.rpartition("/")[0]
        self._limit = len(self._interrupts)
        if self._limit > 1:
            return self._unfinished(f"{name} was not run: stopped twice")
        until = self.context.now + FINALLY_LIMIT
        try:
            while (status := self._tick(finish)) is Status.RUNNING:
                if self.context.now >= until:
                    return self._unfinished(f"{name} did not end within {FINALLY_LIMIT:g} s")
            if status is None:
                self._cut_short(name)
            elif status is Status.FAILURE:
                self._unfinished(self._explain(finish, status))
        except (BrokenOff, CutOff) as error:
            self._cut_short(name, self._broken_off(error))
        except EndOfRecord:
            pass
        except BaseException as error:
            cause = self._cause(error)
            self._blame(cause)
            at = "" if isinstance(cause, NodeError) else f"{self._ticking(name) or name}: "
            self._unfinished(at + _told(cause), _kind(cause))

    def _cut_short(self, name: str, cut: str = "") -> None:
        self._unfinished(f"{name} was cut short by {self._interrupts[-1]}{cut}", "INTERRUPTED")

    def _unfinished(self, reason: str, status: str = "FAILURE") -> None:
        self.outcome.errors.append(f"finally: {reason}")
        self._telling.note("finally", reason=reason)
        if self.outcome.status == "SUCCESS":
            self._end(status, f"the task was done, but its finally failed: {reason}")
        elif status != "FAILURE":
            self._worse(status, f"its finally failed: {reason}")

    def _worse(self, status: str, reason: str) -> None:
        """End with this status where the task itself came to an end; its own reason stays in front."""
        if self.outcome.status in ("SUCCESS", "FAILURE"):
            self._end(status, "; ".join(text for text in (self.outcome.reason, reason) if text))


def _no_end(longest: float) -> str:
    return f"no end within {longest / 60:g} min of virtual time; end it with a 'timeout', or let it take longer"


def _kind(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt | CutOff):
        return "INTERRUPTED"
    return "FAULT" if isinstance(error, DeviceFault) else "ERROR"


def _told(error: BaseException) -> str:
    return writable(error if isinstance(error, StretchError | CutOff) else named(error))
