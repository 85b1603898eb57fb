"""Executing a prepared run: open, tick, stop, close, and say how it ended."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stretch_bt.clock import Clock, VirtualClock
from stretch_bt.errors import DeviceFault, InvalidInput, RecordError, StretchError
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import INTERFACES, is_one, kind_of
from stretch_bt.runtime.context import Seen
from stretch_bt.runtime.foreign_nodes import kept_for, paced_for
from stretch_bt.runtime.load_ahead import load_ahead, load_first
from stretch_bt.runtime.onlooker import Visits
from stretch_bt.runtime.outcome import Outcome
from stretch_bt.runtime.prepare import Task
from stretch_bt.runtime.provenance import places_of
from stretch_bt.runtime.record import RunRecord
from stretch_bt.runtime.record.folder import Kept
from stretch_bt.runtime.report import write_report
from stretch_bt.runtime.result import RunResult, interrupt_result, place_of, result_of, told_in
from stretch_bt.runtime.runner import LONGEST, Runner
from stretch_bt.runtime.signals import signals, unbroken
from stretch_bt.runtime.sketches import Sketches
from stretch_bt.runtime.truth import Truths
from stretch_bt.runtime.view import Shown, View
from stretch_bt.runtime.watcher import Watcher
from stretch_bt.threads import one_thread
from stretch_bt.threads_heard import Heard, threads_heard

if TYPE_CHECKING:
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.hardware.cell_file import CellSpec
    from stretch_bt.runtime.borrowed_devices import BorrowedDevices

__all__ = ["execute"]

_WITHOUT = "leave out --tolerance, or run on a simulated cell"


def execute(
    task: Task,
    out: str | Path | None = None,
    view: View | None = None,
    watch: Callable[[Runner], None] | None = None,
    given: BorrowedDevices | None = None,
    longest: float = LONGEST,
    record: Kept = "full",
) -> RunResult:
    """Open what the task needs, run it, and close everything, whatever happens; given devices are used instead of a cell, and stay open.

    A run in virtual time ends after the `longest` of it, s. `record` says what is kept of it.
    """
    with kept_for(task.built):
        return _executed(task, out, view, watch, given, longest, record)


def _executed(
    task: Task,
    out: str | Path | None,
    view: View | None,
    watch: Callable[[Runner], None] | None,
    given: BorrowedDevices | None,
    longest: float,
    kept: Kept,
) -> RunResult:
    spec = _spec(task, given)
    if given is not None:
        task.prepare(given.hand, given.limits)
    else:
        task.prepare(*((Hand(spec.hand), spec.limits) if spec is not None else ()))
    scene = _scene(task, spec, given)
    clock = _clock(spec, given)
    if isinstance(clock, VirtualClock):
        load_first(sheet=scene is not None and scene.is_sheet)
        task.longest = math.inf if task.built.foreign else longest
        clock = paced_for(task.built, clock)
    else:
        load_ahead(task.program.document.devices[name].interface.__name__ for name in task.devices())
    with one_thread(), threads_heard() as heard:
        run = _Run(task, clock, view, watch, heard)
        with signals(run.interrupted):
            run.record = RunRecord(Path(out) if out is not None else None, kept)
            run.reported = kept == "full"
            result = run.whole(spec, scene, given)
    return run.told_of_signals(result)  # also of those that came while the record was closed


class _Run:
    """One run, from its record to closing: a signal at any instant of it ends it safely and is in its result."""

    record: RunRecord
    #: whether the record gets its page
    reported: bool

    def __init__(
        self, task: Task, clock: Clock, view: View | None, watch: Callable[[Runner], None] | None, heard: Heard
    ) -> None:
        self.task = task
        self.heard = heard
        self.clock = clock
        self.view = view
        self.watch = watch
        self.cell: Cell | BorrowedDevices | None = None
        self.runner: Runner | None = None
        self.came: list[str] = []
        self.opening = False
        self.choice: dict[str, Any] | None = None

    def interrupted(self, why: str) -> None:
        """Take note of a signal: it breaks off the opening of devices, and stops the task from its first tick on."""
        self.came.append(why)
        if self.runner is not None:
            self.runner.interrupt(why)
        elif self.opening:
            self.opening = False  # closing the devices again is not broken off
            raise KeyboardInterrupt(why)

    def whole(self, spec: CellSpec | None, scene: Any, given: BorrowedDevices | None) -> RunResult:
        """Open, drive, close."""
        self.seen = Seen(self.record, self.clock.now)
        listening = ExitStack()
        self.task.context.folder = self.record.folder
        try:
            silent = [] if given is None else given.silent(self.task.devices())
            info = self.task.run_info(spec, scene, silent)
            self.choice = info["choice"]
            self.record.start(self.task.context.about, info, places_of(spec, self.task.program.document.path))
            if self.task.mocks is not None and self.record.folder is not None:
                self.task.mocks.arrays.save(self.record.folder)
            if given is not None:
                listening.enter_context(given.heard_by(self.seen))
            self.open(spec, scene, given)
            return self.drive(self.cell)
        except BaseException as error:
            if self.came and self.runner is None and isinstance(error, KeyboardInterrupt):
                return self.unbegun()
            kinds = {DeviceFault: "FAULT", KeyboardInterrupt: "INTERRUPTED"}
            status = next((name for kind, name in kinds.items() if isinstance(error, kind)), "ERROR")
            if self.runner is None and isinstance(error, StretchError):
                self.unopened(status, error)
            with suppress(RecordError):  # the run's end is reported, not the record's
                self.record.close({"status": status, "reason": str(error)})
            raise
        finally:
            if self.cell is not None:
                self.cell.close()
            listening.close()

    def open(self, spec: CellSpec | None, scene: Any, given: BorrowedDevices | None) -> None:
        """Open the devices, or take those that were given."""
        context = self.task.context
        if given is not None:
            context.devices = given.devices
            self.cell = given
        elif spec is not None:
            self.cell = cell = self.opened(spec, scene)
            context.devices, context.hand = cell.devices, cell.hand

    def opened(self, spec: CellSpec, scene: Any) -> Cell:
        """Return the devices, opened; the only part of a run that a signal breaks off where it is."""
        self.opening = True
        try:
            if self.came:
                raise KeyboardInterrupt(self.came[0])
            from stretch_bt.hardware.cell import open_cell

            return open_cell(
                spec,
                clock=self.clock,
                seed=self.task.seed,
                scene=scene,
                journal=self.seen,
                only=self.task.devices(),
                closing=unbroken,
            )
        finally:
            self.opening = False

    def unopened(self, status: str, error: StretchError) -> None:
        """Finish the record of a run whose devices could not be opened, and note at the error where it is."""
        result = RunResult.without_ticks(status, str(error), place_of(self.record))
        self.write_down(result)
        error.record = result.record

    def unbegun(self) -> RunResult:
        """Return the result of a run that a signal ended before its first tick."""
        reason = f"stopped by {self.came[0]} before the first tick"
        result = RunResult.without_ticks("INTERRUPTED", reason, place_of(self.record))
        self.write_down(result)
        return result

    def drive(self, cell: Cell | BorrowedDevices | None) -> RunResult:
        """Tick to the end, close the devices, and write down what came of it."""
        built = self.task.built
        # what follows from mocks was not found in the scene
        known = dict if cell is None or self.task.mocks is not None else cell.truth_of_simulated
        truths, visits = Truths(built, known), Visits()
        watchers: list[Watcher] = [self.record, truths, visits]
        sketches = None
        if truths.own and cell is not None and self.record.folder is not None:
            sketches = Sketches(truths.names, cell.sketch)
            watchers.append(sketches)
        outcome = self.ticked(cell, watchers)
        errors = cell.close() if cell is not None else []
        outcome.errors += [text for text in map(str, errors) if text not in outcome.errors]
        result = result_of(self.task, outcome, truths, visits, self.seen, self.record)
        result.choice = self.choice
        with told_in(result, "no figures of the twin"):
            result.stats = cell.stats() if cell is not None else []
        with told_in(result, "no sketch of the object"):
            if sketches is not None and self.record.folder is not None:
                sketches.save(self.record.folder)
        self.write_down(result)
        return result

    def ticked(self, cell: Cell | BorrowedDevices | None, watchers: list[Watcher]) -> Outcome:
        """Tick to the end, and show that to who wants to see it."""
        built = self.task.built
        shown = None if self.view is None else Shown(self.view, built)
        runner = Runner(
            built,
            self.task.context,
            self.clock,
            period=self.task.program.document.tick_period,
            cell=cell,
            watchers=watchers if shown is None else [*watchers, shown],
            max_ticks=self.task.most_ticks(),
            longest=self.task.longest,
        )
        if self.watch is not None:
            self.watch(runner)
        self.runner = runner
        for why in self.came:
            runner.interrupt(why)
        if shown is not None:
            shown.start()
        with getattr(cell, "calling", nullcontext)(runner):
            outcome = runner.run()
        self.came += runner.unheard
        if shown is not None:
            shown.stop()
            outcome.errors += shown.errors
        return outcome

    def write_down(self, result: RunResult) -> None:
        """Close the record and write the report; an error of these is reported and changes nothing."""
        self.told_of_signals(result)
        lines, broken = self.heard.take()
        result.errors += lines
        result.broken += broken
        with told_in(result):
            self.record.close(result.to_json())
        with told_in(result, "no report"):
            if self.reported and self.record.folder is not None:
                write_report(self.record.folder)

    def told_of_signals(self, result: RunResult) -> RunResult:
        """Return a result that says which signal came after the task had ended, if one did."""
        if self.came:
            interrupt_result(result, self.came[0])
        return result


def _spec(task: Task, given: BorrowedDevices | None) -> CellSpec | None:
    """Return the cell that the run opens or was given, checked against what the tree needs; None where it has none."""
    if given is None:
        spec = task.cell_spec()
        if spec is None:
            task.scene = None
        return spec
    cell, missing = given.cell, sorted(task.devices() - given.devices.keys())
    if cell is None or not given.is_whole_cell:
        if missing:
            raise InvalidInput(f"the tree needs {', '.join(missing)}; give it in 'devices'")
        _check_kinds(task, given)
        return None if cell is None else cell.spec
    from stretch_bt.runtime.reach import check_devices

    check_devices(task.program, cell.spec, task.devices())
    if missing:
        raise InvalidInput(f"the tree needs {', '.join(missing)}, which this cell was opened without; leave out 'only'")
    return cell.spec


def _check_kinds(task: Task, given: BorrowedDevices) -> None:
    """Refuse a device that is surely of another kind; a device that has what its tree uses need not be of any kind."""
    from stretch_bt.hardware.monitored.base import Monitored

    for name in sorted(task.devices()):
        interface, device = task.program.document.devices[name].interface, given.devices[name]
        sure = isinstance(device, Monitored) or isinstance(getattr(device, "kind", None), str)
        if sure and not is_one(device, interface) and (kind := kind_of(device)) in INTERFACES:
            what = f"the tree needs {name!r}, a device of kind {interface.__name__}, and was given one of kind {kind}"
            raise InvalidInput(f"{what}; give each device under the name that the tree declares")


def _clock(spec: CellSpec | None, given: BorrowedDevices | None) -> Clock:
    if given is not None:
        return given.clock
    if spec is None:
        return VirtualClock()
    from stretch_bt.hardware.cell import clock_of

    return clock_of(spec)


def _scene(task: Task, spec: CellSpec | None, given: BorrowedDevices | None) -> Any:
    if given is not None:
        return None if given.cell is None else given.cell.scene
    if spec is None or not any(spec.devices[name].implementation.cls.simulated for name in _opened_names(task, spec)):
        if task.tolerance is not None:
            raise InvalidInput(f"a tolerance bounds the twin, and nothing is simulated in this run; {_WITHOUT}")
        return None
    from stretch_bt.simulation.advisor.demand import demand
    from stretch_bt.simulation.scene import load_scene

    if task.scene is None:
        why = "name one with --scene: the scene of the tree counts where no cell is named"
        if task.mocks is not None:
            what, *others = task.unmocked()
            more = f" and {len(others)} more" if others else ""
            why = f"no mock stands for {what!r}{more}: mock it, or name a scene with --scene"
        raise InvalidInput(f"{spec.path.name} has simulated devices and needs a scene; {why}")
    return demand(load_scene(task.scene), task.tolerance)


def _opened_names(task: Task, spec: CellSpec) -> list[str]:
    """Return the devices that the run opens."""
    return [name for name in spec.devices if name in task.devices()]
