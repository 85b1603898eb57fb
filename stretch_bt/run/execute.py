"""Executing a prepared run: open, tick, stop, close, and say how it ended."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from py_trees.common import Status

from stretch_bt.errors import DeviceFault, InvalidInput, RecordError
from stretch_bt.hardware.interfaces import Device
from stretch_bt.run.clock import Clock, RealClock, VirtualClock
from stretch_bt.run.context import Seen
from stretch_bt.run.load_ahead import load_ahead, load_first
from stretch_bt.run.onlooker import Onlooker, Visits
from stretch_bt.run.prepare import Task
from stretch_bt.run.record import RunRecord
from stretch_bt.run.record.plain import plain
from stretch_bt.run.report import write_report
from stretch_bt.run.runner import Outcome, Runner, Watcher
from stretch_bt.run.signals import signals, unbroken
from stretch_bt.run.sketches import Sketches
from stretch_bt.run.truth import Truths, output_values
from stretch_bt.threads import one_thread
from stretch_bt.tree.blame import Broken
from stretch_bt.tree.build import BuiltTree

if TYPE_CHECKING:
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.hardware.cell_file import CellSpec

__all__ = ["RunResult", "View", "execute", "interrupt_result"]

#: device implementations that go by whatever clock they are given
_ANY_CLOCK = ("simulated", "replay")


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
    """Tells a view of every change, and at each tick what the running nodes say they are doing.

    A view that breaks, as when its terminal is closed, is left alone from then on: the task goes on.
    """

    def __init__(self, view: View, built: BuiltTree) -> None:
        self.view = view
        self.built = built
        self.now = 0.0
        self.broken = False

    def begin_tick(self, tick: int, time: float) -> None:
        """Show the time, and what runs."""
        self.now = time
        nodes = self.built.nodes.items()
        self._show({p: (n.status.name, n.feedback_message) for p, n in nodes if n.status is Status.RUNNING})

    def status(self, path: str, status: str, reason: str = "") -> None:
        """Show a change."""
        self._show({path: (status, reason)})

    def _show(self, statuses: Mapping[str, tuple[str, str]]) -> None:
        if self.broken:
            return
        try:
            self.view.update(self.now, statuses)
        except (Exception, SystemExit):  # rich turns a closed pipe into SystemExit
            self.broken = True


@dataclass(slots=True)
class RunResult:
    """How a run ended, what it found, and where its record is; the fields of `run --json`."""

    status: str
    reason: str
    outputs: dict[str, dict[str, Any]]
    truth: dict[str, dict[str, Any]]
    ticks: int
    task_seconds: float
    wall_seconds: float
    cpu_seconds: float
    record: str
    overruns: int = 0
    errors: list[str] = field(default_factory=list)
    unmet: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    readings: dict[str, Any] = field(default_factory=dict)
    stats: list[dict[str, Any]] = field(default_factory=list)
    broken: list[Broken] = field(default_factory=list)

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `run --json` prints."""
        fields: dict[str, Any] = plain(asdict(self))
        return fields


def execute(
    task: Task,
    out: str | Path | None = None,
    view: View | None = None,
    watch: Callable[[Runner], None] | None = None,
    devices: Mapping[str, Device] | None = None,
) -> RunResult:
    """Open what the task needs, run it, and close everything, whatever happens; `devices` are used instead of a cell's."""
    spec = task.cell_spec() if devices is None else None
    missing = sorted(task.devices() - devices.keys()) if devices is not None else []
    if missing:
        raise InvalidInput(f"the tree needs {', '.join(missing)}; give it in 'devices'")
    if spec is None:
        task.scene = None
    task.prepare(spec)
    scene = _load_scene(task, spec)
    real = spec is not None and any(d.use not in _ANY_CLOCK for d in spec.devices.values())
    if real:
        load_ahead()
    else:
        load_first(sheet=scene is not None and scene.fidelity == "sheet")
    clock: Clock = RealClock() if real else VirtualClock()
    with one_thread():
        run = _Run(task, clock, view, watch)
        with signals(run.interrupted):
            run.record = RunRecord(Path(out) if out is not None else None)
            return run.whole(spec, scene, devices)


class _Run:
    """One run, from its record to closing: a signal at any instant of it ends it safely and is in its result."""

    record: RunRecord

    def __init__(self, task: Task, clock: Clock, view: View | None, watch: Callable[[Runner], None] | None) -> None:
        self.task = task
        self.clock = clock
        self.view = view
        self.watch = watch
        self.cell: Cell | Given | None = None
        self.runner: Runner | None = None
        self.came: list[str] = []
        self.opening = False

    def interrupted(self, why: str) -> None:
        """Take note of a signal: it breaks off the opening of devices, and stops the task from its first tick on."""
        self.came.append(why)
        if self.runner is not None:
            self.runner.interrupt(why)
        elif self.opening:
            self.opening = False  # what closes the devices again is not broken off
            raise KeyboardInterrupt(why)

    def whole(self, spec: CellSpec | None, scene: Any, devices: Mapping[str, Device] | None) -> RunResult:
        """Open, drive, close."""
        self.seen = Seen(self.record)
        self.task.context.folder = self.record.folder
        try:
            self.record.start(self.task.context.about, self.task.run_info(spec, scene))
            self.open(spec, scene, devices)
            return self.drive(self.cell)
        except BaseException as error:
            if self.came and self.runner is None and isinstance(error, KeyboardInterrupt):
                return self.unbegun()
            kinds = {DeviceFault: "FAULT", KeyboardInterrupt: "INTERRUPTED"}
            status = next((name for kind, name in kinds.items() if isinstance(error, kind)), "ERROR")
            with suppress(RecordError):  # what ended the run is told, not what became of its record
                self.record.close({"status": status, "reason": str(error)})
            raise
        finally:
            if self.cell is not None:
                self.cell.close()

    def open(self, spec: CellSpec | None, scene: Any, devices: Mapping[str, Device] | None) -> None:
        """Open the devices, or take those that were given."""
        context = self.task.context
        if devices is not None:
            context.devices = devices
            self.cell = Given(devices)
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
                now=self.clock.now,
                seed=self.task.seed,
                scene=scene,
                journal=self.seen,
                only=self.task.devices(),
                closing=unbroken,
            )
        finally:
            self.opening = False

    def unbegun(self) -> RunResult:
        """Return the result of a run that a signal ended before its first tick."""
        reason = f"stopped by {self.came[0]} before the first tick"
        result = RunResult("INTERRUPTED", reason, {}, {}, 0, 0.0, 0.0, 0.0, str(self.record.folder))
        self.write_down(result)
        return result

    def drive(self, cell: Cell | Given | None) -> RunResult:
        """Tick to the end, close the devices, and write down what came of it."""
        built = self.task.built
        truths, visits = Truths(built.outputs, cell.truth if cell is not None else dict), Visits()
        watchers: list[Watcher] = [self.record, truths, visits]
        sketches = None
        if truths.own and cell is not None:
            sketches = Sketches(truths.names, cell.sketch)
            watchers.append(sketches)
        if self.view is not None:
            watchers.append(Shown(self.view, built))
        period = self.task.program.document.tick_period
        runner = Runner(
            built,
            self.task.context,
            self.clock,
            period=period,
            cell=cell,
            watchers=watchers,
            max_ticks=self.task.most_ticks(),
        )
        if self.watch is not None:
            self.watch(runner)
        self.runner = runner
        for why in self.came:
            runner.interrupt(why)
        try:
            if self.view is not None:
                self.view.start(built.outline())
            outcome = runner.run()
            self.came += runner.unheard
        finally:
            if self.view is not None:
                with suppress(Exception, SystemExit):  # its terminal may be gone
                    self.view.stop()
        errors = cell.close() if cell is not None else []
        outcome.errors += [text for text in map(str, errors) if text not in outcome.errors]
        result = _result(self.task, outcome, truths, visits, self.seen, self.record)
        with _told_in(result, "no figures of the twin"):
            result.stats = cell.stats() if cell is not None else []
        with _told_in(result, "no sketch of the object"):
            if sketches is not None:
                sketches.save(self.record.folder)
        self.write_down(result)
        return result

    def write_down(self, result: RunResult) -> None:
        """Close the record and write the report; what fails of it is told and changes nothing."""
        if self.came:
            interrupt_result(result, self.came[0])
        with _told_in(result):
            self.record.close(result.to_json())
        with _told_in(result, "no report"):
            write_report(self.record.folder)
        if self.came:
            interrupt_result(result, self.came[0])


@contextmanager
def _told_in(result: RunResult, what: str = "") -> Iterator[None]:
    """Add what breaks in the block to the errors of a result: nothing after the last tick changes how a run ended."""
    try:
        yield
    except RecordError as error:
        result.errors.append(str(error))
    except Exception as error:
        result.errors.append(f"{what or 'no result.json'} ({type(error).__name__}: {error})")


def interrupt_result(result: RunResult, why: str) -> None:
    """Say in a result that a signal came after the task had ended; a record that is closed keeps how the task ended.

    A device fault and an error stay what they are.
    """
    if result.status in ("SUCCESS", "FAILURE"):
        ended = f"{why} came after the task had ended with {result.status}"
        result.status, result.reason = "INTERRUPTED", f"{ended}: {result.reason}" if result.reason else ended


class Given:
    """Devices that the caller gave, and keeps."""

    def __init__(self, devices: Mapping[str, Device]) -> None:
        self.devices = devices

    def truth(self) -> dict[str, float]:
        """Nothing is known."""
        return {}

    def sketch(self) -> dict[str, list[tuple[float, float]]]:
        """Nothing is known."""
        return {}

    def stats(self) -> list[dict[str, Any]]:
        """Nothing is simulated."""
        return []

    def stop(self) -> list[Exception]:
        """Stop every device."""
        errors: list[Exception] = []
        for device in self.devices.values():
            try:
                device.stop()
            except Exception as error:  # one that breaks must not keep the others moving
                errors.append(error)
        return errors

    def close(self) -> list[Exception]:
        """Leave them open."""
        return []


def _load_scene(task: Task, spec: CellSpec | None) -> Any:
    if spec is None or not spec.simulated:
        return None
    from stretch_bt.simulation.scene import load_scene

    if task.scene is None:
        raise InvalidInput("a simulated cell needs a scene; name one with --scene, or in the tree")
    return load_scene(task.scene)


def _result(task: Task, outcome: Outcome, truths: Truths, visits: Visits, seen: Seen, record: RunRecord) -> RunResult:
    good = outcome.status == "SUCCESS"
    outputs, truth = output_values(task.built.outputs, truths.found, succeeded=good)
    unmet = task.mocks.expect.unmet(outcome.status, outcome.ticks, visits.seen) if task.mocks else []
    return RunResult(
        status=outcome.status,
        reason=outcome.reason,
        outputs=outputs,
        truth=truth,
        ticks=outcome.ticks,
        task_seconds=outcome.task_seconds,
        wall_seconds=outcome.wall_seconds,
        cpu_seconds=outcome.cpu_seconds,
        record=str(record.folder),
        overruns=outcome.overruns,
        errors=outcome.errors,
        broken=outcome.broken,
        unmet=unmet,
        notes=task.notes,
        readings={} if good else seen.shown(),
    )
