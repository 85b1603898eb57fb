"""Running a task: file to result, on a scene, a cell or mocks."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from datetime import datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from stretch_bt.errors import CellError, DeviceFault, InvalidInput
from stretch_bt.run.clock import Clock, RealClock, VirtualClock
from stretch_bt.run.context import RunContext, Seen
from stretch_bt.run.mocks import Mocks, read_mocks
from stretch_bt.run.record import RunRecord
from stretch_bt.run.report import write_report
from stretch_bt.run.runner import Outcome, Runner, Watcher
from stretch_bt.run.truth import Truths, output_values
from stretch_bt.source import Map, Scalar
from stretch_bt.tree.build import BuiltTree, build
from stretch_bt.tree.document import Document
from stretch_bt.tree.program import Program, load_program

if TYPE_CHECKING:
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.hardware.cell_file import CellSpec

__all__ = ["RunResult", "Task", "View", "run"]

DEFAULT_CELL = "simulated"
#: device implementations that go by whatever clock they are given
_ANY_CLOCK = ("simulated", "replay")


class View(Protocol):
    """Who shows a run while it goes on."""

    def start(self, outline: list[tuple[int, str, str]]) -> None:
        """Begin to show a tree."""
        ...

    def stop(self) -> None:
        """End."""
        ...


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


@dataclass(slots=True)
class Task:
    """A run being prepared: everything that is known before a device is opened."""

    program: Program
    params: Mapping[str, Any]
    seed: int = 0
    scene: str | None = None
    cell: str | None = None
    mocks: Mocks | None = None
    context: RunContext = field(default_factory=RunContext)
    built: BuiltTree = field(init=False)

    def __post_init__(self) -> None:
        if self.mocks is not None:
            self.mocks.attach(self.context.mocked_readings)
        self.built = build(self.program, self.context, self.mocks)
        if self.mocks is not None:
            self.mocks.check_matches([*self.built.nodes, *self.mocks.replaced])

    def devices(self) -> set[str]:
        """Return the devices that the run needs: those of nodes and readings that are not mocked."""
        mocked = self.context.mocked_readings
        return self.built.devices | {r.partition(".")[0] for r in self.built.readings if r not in mocked}

    def cell_spec(self) -> CellSpec | None:
        """Return the cell that the run opens, checked against what the tree declares; None when it needs none."""
        wanted = self.devices()
        if not wanted and self.cell is None:
            return None
        from stretch_bt.hardware.cell_file import load_cell

        spec = load_cell(self.cell or DEFAULT_CELL)
        declared = self.program.document.devices
        findings = []
        for name in sorted(wanted):
            interface = declared[name].interface.__name__
            present = spec.devices.get(name)
            if present is None or present.type != interface:
                what = f"the tree needs {name!r}, a device of kind {interface}"
                hint = f"add 'devices: {{{name}: {{type: {interface}, use: ...}}}}', or run another cell"
                findings.append(
                    declared[name].mark.error("device-missing", f"{what}, and {spec.path.name} has none", hint)
                )
        if findings:
            raise CellError(findings)
        return spec

    def header(self) -> dict[str, Any]:
        """Return what identifies the run: the same for identical runs, without paths, hosts or times."""
        document = self.program.document
        outs = {
            f"main/{n}": d.type.name
            for n, d in {**self.program.main.signature.keys, **self.program.main.signature.outs}.items()
        }
        return {
            "tree": Path(document.file).name,
            "files": {Path(name).name: digest for name, digest in document.files.items()},
            "params": {name: param.value for name, param in document.params.items()},
            "seed": self.seed,
            "scene": Path(self.scene).name if self.scene else None,
            "cell": Path(self.cell).name if self.cell else None,
            "mocks": Path(self.mocks.file).name if self.mocks else None,
            "tick": document.tick_period,
            "keys": outs,
            "versions": versions("stretch-bt", "py_trees", "numpy"),
        }

    def run_info(self, spec: CellSpec | None) -> dict[str, Any]:
        """Return what a replay needs and what a person may want to know."""
        document = self.program.document
        return {
            "tree": str(document.path.resolve()) if document.path else document.file,
            "sources": sources(self.program),
            "set": {k: str(v) if not isinstance(v, int | float | list | bool) else v for k, v in self.params.items()},
            "seed": self.seed,
            "scene": self.scene,
            "cell": self.cell,
            "hand": asdict(spec.hand) if spec is not None else None,
            "mocks": self.mocks.path.read_text("utf-8") if self.mocks else None,
            "started": datetime.now().astimezone().isoformat(timespec="seconds"),
            "host": platform.node(),
            "command": sys.argv,
            "python": platform.python_version(),
            "versions": versions(
                "stretch-bt", "py_trees", "numpy", "scipy", "opencv-contrib-python-headless", "pydantic"
            ),
        }


def versions(*names: str) -> dict[str, str]:
    """Return the installed versions of packages."""
    found = {}
    for name in names:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def sources(program: Program) -> dict[str, str]:
    """Return the text of every tree file, by its path relative to the main one, so that a record can be replayed alone."""
    main = program.document
    assert main.path is not None
    found = {main.path.name: main.path.read_text("utf-8")}

    def visit(document: Document, folder: Path) -> None:
        for key, imported in document.imports.items():
            table = document.root.get("imports")
            target = table.get(key) if isinstance(table, Map) else None
            if isinstance(target, Scalar) and imported.path is not None:
                found[str(folder / target.text)] = imported.path.read_text("utf-8")
                visit(imported, (folder / target.text).parent)

    visit(main, Path())
    return found


def run(
    tree: str | Path,
    *,
    scene: str | Path | None = None,
    cell: str | Path | None = None,
    params: Mapping[str, Any] | None = None,
    seed: int = 0,
    mocks: str | Path | None = None,
    out: str | Path | None = None,
    view: View | None = None,
    watch: Callable[[Runner], None] | None = None,
) -> RunResult:
    """Run a tree and return how it ended.

    Parameters
    ----------
    tree
        A tree file, or the name of a shipped one.
    scene, cell
        What is simulated, or which devices are used; by default the tree's scene on the simulated cell.
    params
        Parameters of the tree: text as in `--set`, or SI numbers.
    seed
        Of everything random in a simulation.
    mocks
        A mocks file; devices that only mocked nodes use are not opened.
    out
        The record's folder, which must be empty or absent; by default a new one under `runs`.
    view
        Who shows the run while it goes on.
    watch
        Called with the runner before the first tick.

    Raises
    ------
    FileError
        A file is wrong; nothing has moved.
    DeviceFault
        A device could not be opened; nothing has moved.
    """
    program = load_program(tree, params).require()
    if "main" not in program.document.trees:
        raise InvalidInput(f"{program.document.file} has no tree 'main'; it is a library for import")
    table = read_mocks(Path(mocks)) if mocks is not None else None
    default = _own_scene(program) if cell is None else None
    task = Task(program, params or {}, seed, str(scene or default or "") or None, str(cell) if cell else None, table)
    return execute(task, out, view, watch)


def _own_scene(program: Program) -> str | None:
    """Return the scene that a tree names: a file beside the tree, or the name of a shipped one."""
    named, path = program.document.scene, program.document.path
    if named is None or path is None:
        return None
    beside = path.parent / named.text
    return str(beside) if named.text.endswith((".yaml", ".yml")) and beside.exists() else named.text


def execute(
    task: Task, out: str | Path | None = None, view: View | None = None, watch: Callable[[Runner], None] | None = None
) -> RunResult:
    """Open what the task needs, run it, and close everything, whatever happens."""
    spec = task.cell_spec()
    if spec is None:
        task.scene = None
    scene = _load_scene(task, spec)
    real = spec is not None and any(d.use not in _ANY_CLOCK for d in spec.devices.values())
    clock: Clock = RealClock() if real else VirtualClock()
    record = RunRecord(Path(out) if out is not None else None)
    record.start(task.header(), task.run_info(spec))
    seen = Seen(record)
    cell: Cell | None = None
    try:
        if spec is not None:
            from stretch_bt.hardware.cell import open_cell

            cell = open_cell(spec, now=clock.now, seed=task.seed, scene=scene, journal=seen, only=task.devices())
            task.context.devices, task.context.hand = cell.devices, cell.hand
        return _drive(task, cell, clock, record, seen, view, watch)
    except BaseException as error:
        status = "FAULT" if isinstance(error, DeviceFault) else "ERROR"
        record.close({"status": status, "reason": str(error)})
        raise
    finally:
        if cell is not None:
            cell.close()


def _load_scene(task: Task, spec: CellSpec | None) -> Any:
    if spec is None or not spec.simulated:
        return None
    from stretch_bt.simulation.scene import load_scene

    if task.scene is None:
        raise InvalidInput("a simulated cell needs a scene; name one with --scene, or in the tree")
    return load_scene(task.scene)


def _drive(
    task: Task,
    cell: Cell | None,
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
        watchers.append(view)  # type: ignore[arg-type]
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


class Visits:
    """A watcher that notes which node came to which status, for what a mocks file expects."""

    def __init__(self) -> None:
        self.seen: set[tuple[str, str]] = set()

    def begin_tick(self, tick: int, time: float) -> None:
        """Nothing to do."""

    def status(self, path: str, status: str, reason: str = "") -> None:
        """Note it."""
        self.seen.add((path, status))

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Nothing to do."""

    def note(self, kind: str, **fields: Any) -> None:
        """Nothing to do."""
