"""A task as a behaviour of somebody else's py_trees tree, on an open cell."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import py_trees
from py_trees.common import Status

from stretch_bt.arguments import check_arguments
from stretch_bt.clock import Clock, MixedClock, VirtualClock
from stretch_bt.errors import InvalidInput, StretchError
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.foreign_nodes import paced_for, set_up, shut_down
from stretch_bt.runtime.pending_finally import FinallyTicker, worst_of
from stretch_bt.runtime.prepare_nodes import prepare_nodes
from stretch_bt.runtime.signals import unbroken
from stretch_bt.runtime.stop import failed_at, started_leaves, stop_tree
from stretch_bt.threads import one_thread
from stretch_bt.tree.build import build
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.program import load_program

if TYPE_CHECKING:
    from stretch_bt.runtime.open_cell import OpenCell

__all__ = ["Subtree", "subtree"]

#: periods of the tree that may lie between two ticks; a hand that nobody looks at goes further than it should
MOST_PERIODS = 4.0
_ROUNDING = 1e-9


def subtree(tree: str | Path, cell: OpenCell, *, params: Mapping[str, Any] | None = None) -> Subtree:
    """Return a task as a behaviour that any py_trees tree can tick, on the devices of an open cell.

    Ticked, it goes through the task as a run does; it begins anew each time it is started. Interrupted, it stops its own motions at once,
    and its `finally` is owed by the cell: it is ticked before anything of the cell starts again, on every tick of a tree that
    `cell.attend` was given, and at the latest when the cell is closed.

    A tick raises DeviceFault when a device fails, and StretchError when more than four tick periods of the task lie between two ticks;
    every device is stopped then.

    Raises
    ------
    TreeError, CellError
        The tree is wrong, or needs devices that the cell does not have.
    """
    return Subtree(tree, cell, params)


class Subtree(py_trees.behaviour.Behaviour):
    """See `subtree`. `outputs` holds what the task gave when it ended last, SI, a number with a deviation as an Estimate."""

    def __init__(self, tree: str | Path, cell: OpenCell, params: Mapping[str, Any] | None) -> None:
        check_arguments(tree=tree, params=params)
        super().__init__(name=Path(tree).stem)
        self.cell = cell
        self.program = load_program(tree, dict(params or {})).require()
        if "main" not in self.program.document.trees:
            raise InvalidInput(f"{self.program.document.file} has no tree 'main'; it is a library for import")
        asked = self._asked(dict(params or {}))
        if asked:
            self.program = load_program(tree, {**dict(params or {}), **asked}).require()
        self.period = self.program.document.tick_period
        self.outputs: dict[str, Any] = {}
        self._built: BuiltTree | None = None
        self._finally: FinallyTicker | None = None
        self._ended = Status.INVALID
        self._last: float | None = None
        self._ticked_at = float("-inf")
        self._clock: Clock = cell.clock
        self._check()

    def _check(self) -> None:
        """Refuse what could never be ticked here, before anything moves."""
        from stretch_bt.runtime.reach import check_devices

        built = build(self.program, RunContext())
        check_devices(self.program, self.cell.cell.spec, built.needed())
        missing = sorted(built.needed() - self.cell.devices.keys())
        if missing:
            raise InvalidInput(f"{self.name} needs {', '.join(missing)}, which this cell was opened without")

    def _asked(self, params: dict[str, Any]) -> dict[str, Any]:
        """Return the params that the scene of the cell asks for, as the force that its object bears; those that are given come first."""
        scene, known = self.cell.cell.scene, self.program.document.params
        asked = {} if scene is None else {key.text: value for key, value in scene.placed_params.items()}
        return {name: value for name, value in asked.items() if name in known and name not in params}

    @property
    def is_ending(self) -> bool:
        """Whether its task has ended, and its `finally` goes on."""
        return self._finally is not None

    # --- what py_trees calls

    def initialise(self) -> None:
        """Begin anew, at the next tick that owes nothing."""
        self._built = self._finally = self._last = None
        self.feedback_message = ""
        # an interrupt that broke may have left it among them
        self._end()

    def update(self) -> Status:
        """Tick once."""
        try:
            with one_thread():
                return self._ticked()
        except BaseException as error:
            self._give_up(error)
            raise
        finally:
            self._last = self._time()

    def terminate(self, new_status: Status) -> None:
        """Stop its own motions where it is interrupted; never raises, for the other behaviours have to be stopped, too."""
        if new_status is Status.INVALID and self._built is not None:
            try:
                with unbroken():  # a signal must not lose what is owed
                    self._interrupt()
            except BaseException as error:
                self.cell.pending_finally.errors.append(error)

    # --- a tick

    def _ticked(self) -> Status:
        errors = self.cell.pending_finally.take_errors()
        if errors:
            raise worst_of(errors)
        if self._built is None:
            if self.cell.pending_finally:
                self.cell.pending_finally.tick_unattended()
                self.feedback_message = "waits for the finally of what was interrupted"
                return Status.RUNNING
            self._begin()
        self._go_on()
        self.cell.begin_tick(self._context)
        if self._finally is None:
            self._tick_body()
        return self._tick_finally() if self._finally is not None else Status.RUNNING

    def _begin(self) -> None:
        self._context = self.cell.new_context()
        self._context.period = self.period
        self._built = build(self.program, self._context, within=self.name)
        prepare_nodes(self._built)
        set_up(self._built)
        # its timers count the machine's time, so no task with one goes faster
        self._clock = paced_for(self._built, self.cell.clock)
        self.cell.records.clear()
        self.cell.live.append(self)

    def _end(self) -> None:
        if self in self.cell.live:
            self.cell.live.remove(self)

    def _time(self) -> float:
        """Return the time for counting pauses, s; a mixed clock lags behind it after too long a pause."""
        clock = self.cell.clock
        return clock.machine.now() if isinstance(clock, MixedClock) else clock.now()

    def _go_on(self) -> None:
        """Let a virtual clock go on where nothing else did since the last tick; refuse a pause that is too long."""
        clock, last = self.cell.clock, self._last
        period = min([each.period for each in self.cell.live] + self.cell.pending_finally.periods)
        if last is not None and self._time() - last > MOST_PERIODS * self.period + _ROUNDING:
            raise StretchError(
                f"{self.name}: {self._time() - last:.3g} s lie between two ticks, and it may be {MOST_PERIODS * self.period:.3g} s; "
                f"tick the tree every {self.period:g} s, or give the task a longer 'tick'"
            )
        if isinstance(clock, MixedClock):
            clock.follow(self.period)
        elif isinstance(clock, VirtualClock) and clock.now() <= self._ticked_at + _ROUNDING:
            self._advance(period)
        if not self._context.ticks:
            self._context.start = clock.now()
        self._ticked_at = clock.now()

    def _advance(self, period: float) -> None:
        """Let a virtual clock go on, with a behaviour of another package no faster than the machine's."""
        due = self.cell.clock.now() + period
        while not self._clock.reached(due):
            self._clock.wait_until(due)

    def _tick_body(self) -> None:
        assert self._built is not None
        root = self._built.root
        for _ in root.tick():
            pass
        if root.status is Status.RUNNING:
            return
        self._ended = root.status
        if root.status is Status.FAILURE:
            node = failed_at(root)
            self.feedback_message = f"{node.path}: {node.feedback_message or 'failed'}"
        self._finally = FinallyTicker(self._built, self._context)

    def _tick_finally(self) -> Status:
        """Tick what follows the task; its outcome stands unless that broke."""
        assert self._finally is not None
        if not self._finally.tick():
            return Status.RUNNING
        ticker, built = self._finally, self._built
        self._built = self._finally = None
        self._end()
        assert built is not None
        errors = [*ticker.errors, *shut_down(built)]
        if errors:
            raise worst_of(errors)
        if ticker.failed and self._ended is Status.SUCCESS:
            self.feedback_message = f"the task was done, but its finally failed: {ticker.failed}"
            return Status.FAILURE
        self.outputs = {name: slot.held() for name, (_, slot) in built.outputs.items() if slot.value is not MISSING}
        return self._ended

    # --- other ends

    def _interrupt(self) -> None:
        built, ticker = self._built, self._finally
        assert built is not None
        if ticker is None:
            # the owed `finally` is taken before the nodes are stopped: those forget that they were entered
            ticker = FinallyTicker(built, self._context)
            begun = started_leaves(built.root)
            self.feedback_message = f"interrupted in {begun[-1].path}" if begun else ""
            self.cell.pending_finally.errors += stop_tree(built.root)
        self.cell.pending_finally.add(ticker, self.period)
        self._built = self._finally = None
        self._end()

    def _give_up(self, error: BaseException) -> None:
        """Stop every device and owe the `finally`, because of an error that is about to be raised."""
        try:
            if self._built is not None:
                with unbroken() as errors:
                    errors.append(error)
                    self._interrupt()
        finally:
            self.cell.pending_finally.errors += self.cell.cell.stop()  # raised at the next tick or call
