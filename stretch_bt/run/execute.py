"""Executing a prepared run: open, tick, stop, close, and say how it ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from py_trees.common import Status

from stretch_bt.errors import DeviceFault, InvalidInput
from stretch_bt.hardware.interfaces import Device
from stretch_bt.run.clock import Clock, RealClock, VirtualClock
from stretch_bt.run.context import Seen
from stretch_bt.run.onlooker import Onlooker, Visits
from stretch_bt.run.prepare import Task
from stretch_bt.run.record import RunRecord
from stretch_bt.run.report import write_report
from stretch_bt.run.runner import Outcome, Runner, Watcher
from stretch_bt.run.truth import Truths, output_values
from stretch_bt.tree.build import BuiltTree

if TYPE_CHECKING:
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.hardware.cell_file import CellSpec

__all__ = ["RunResult", "View", "execute"]

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
    """Tells a view of every change, and at each tick what the running nodes say they are doing."""

    def __init__(self, view: View, built: BuiltTree) -> None:
        self.view = view
        self.built = built
        self.now = 0.0

    def begin_tick(self, tick: int, time: float) -> None:
        """Show the time, and what runs."""
        self.now = time
        running = {
            p: (n.status.name, n.feedback_message) for p, n in self.built.nodes.items() if n.status is Status.RUNNING
        }
        self.view.update(time, running)

    def status(self, path: str, status: str, reason: str = "") -> None:
        """Show a change."""
        self.view.update(self.now, {path: (status, reason)})


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
    readings: dict[str, Any] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `run --json` prints."""
        return asdict(self)


def execute(
    task: Task,
    out: str | Path | None = None,
    view: View | None = None,
    watch: Callable[[Runner], None] | None = None,
    devices: Mapping[str, Device] | None = None,
) -> RunResult:
    """Open what the task needs, run it, and close everything, whatever happens; `devices` are used instead of a cell's."""
    spec = task.cell_spec() if devices is None else None
    if spec is None:
        task.scene = None
    scene = _load_scene(task, spec)
    real = spec is not None and any(d.use not in _ANY_CLOCK for d in spec.devices.values())
    clock: Clock = RealClock() if real else VirtualClock()
    record = RunRecord(Path(out) if out is not None else None)
    record.start(task.header(), task.run_info(spec))
    seen = Seen(record)
    cell: Cell | Given | None = None
    try:
        if devices is not None:
            cell = Given(devices)
            task.context.devices = devices
        if spec is not None:
            from stretch_bt.hardware.cell import open_cell

            cell = open_cell(spec, now=clock.now, seed=task.seed, scene=scene, journal=seen, only=task.devices())
            task.context.devices, task.context.hand = cell.devices, cell.hand
        return _drive(task, cell, clock, record, seen, view, watch)
    except BaseException as error:
        kinds = {DeviceFault: "FAULT", KeyboardInterrupt: "INTERRUPTED"}
        status = next((name for kind, name in kinds.items() if isinstance(error, kind)), "ERROR")
        record.close({"status": status, "reason": str(error)})
        raise
    finally:
        if cell is not None:
            cell.close()


class Given:
    """Devices that the caller gave, and keeps."""

    def __init__(self, devices: Mapping[str, Device]) -> None:
        self.devices = devices

    def truth(self) -> dict[str, float]:
        """Nothing is known."""
        return {}

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


def _drive(
    task: Task,
    cell: Cell | Given | None,
    clock: Clock,
    record: RunRecord,
    seen: Seen,
    view: View | None,
    watch: Callable[[Runner], None] | None,
) -> RunResult:
    truths = Truths(task.built.outputs, cell.truth if cell is not None else dict)
    visits = Visits()
    watchers: list[Watcher] = [record, truths, visits]
    if view is not None:
        watchers.append(Shown(view, task.built))
        view.start(task.built.outline())
    runner = Runner(
        task.built, task.context, clock, period=task.program.document.tick_period, cell=cell, watchers=watchers
    )
    if watch is not None:
        watch(runner)
    try:
        outcome = runner.run()
    finally:
        if view is not None:
            view.stop()
    errors = cell.close() if cell is not None else []
    outcome.errors += [text for text in map(str, errors) if text not in outcome.errors]
    result = _result(task, outcome, truths, visits, seen, record)
    record.close(result.to_json())
    write_report(record.folder)
    return result


def _result(task: Task, outcome: Outcome, truths: Truths, visits: Visits, seen: Seen, record: RunRecord) -> RunResult:
    outputs, truth = output_values(task.built.outputs, truths.found)
    unmet = task.mocks.expect.unmet(outcome.status, outcome.ticks, visits.seen) if task.mocks else []
    good = outcome.status == "SUCCESS"
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
        unmet=unmet,
        readings={} if good else seen.shown(),
    )
