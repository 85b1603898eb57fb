"""Running a task: file to result, on a scene, a cell or mocks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stretch_bt.arguments import check_arguments
from stretch_bt.errors import Diagnostic, InvalidInput, SceneError
from stretch_bt.hardware.interfaces import Device
from stretch_bt.hardware.own_modules import Modules
from stretch_bt.runtime.execute import execute
from stretch_bt.runtime.mocks import for_another
from stretch_bt.runtime.mocks_file import read_mocks
from stretch_bt.runtime.prepare import Task
from stretch_bt.runtime.record.folder import KEPT, Kept
from stretch_bt.runtime.result import RunResult
from stretch_bt.runtime.runner import LONGEST, Runner
from stretch_bt.runtime.view import View
from stretch_bt.source import MISSPELT, Scalar, closest, did_you_mean
from stretch_bt.source.scene_params import scene_params
from stretch_bt.threads_heard import threads_heard
from stretch_bt.tree.program import load_program
from stretch_bt.units import parse_time

if TYPE_CHECKING:
    from stretch_bt.runtime.borrowed_devices import BorrowedDevices
    from stretch_bt.runtime.open_cell import OpenCell
    from stretch_bt.simulation.scene.sections import Tolerance

__all__ = ["RunResult", "Task", "View", "execute", "run", "task_of"]


@threads_heard()
def run(
    tree: str | Path,
    *,
    scene: str | Path | None = None,
    cell: str | Path | OpenCell | None = None,
    params: Mapping[str, Any] | None = None,
    seed: int = 0,
    mocks: str | Path | Mapping[str, Any] | None = None,
    out: str | Path | None = None,
    view: View | None = None,
    watch: Callable[[Runner], None] | None = None,
    devices: Mapping[str, Device] | None = None,
    modules: str | Path | None = None,
    longest: float | str = LONGEST,
    record: Kept = "full",
    tolerance: Mapping[str, Any] | None = None,
) -> RunResult:
    """Run a tree and return how it ended; prints of its nodes go where the caller's own prints go.

    Parameters
    ----------
    tree
        A tree file, or the name of a shipped one.
    scene, cell
        What is simulated, or which devices are used; by default the tree's scene on the simulated cell. A scene may ask for
        params, such as a force that its object bears; those in `params` come first. A cell may be an open one, which has its
        scene, keeps its clock and its hand, and stays open.
    params
        Params of the tree: text as in `--set`, or SI numbers.
    seed
        Seed of everything random in a simulation.
    mocks
        A mocks file, or its content as text of several lines or as a mapping; devices that only mocked nodes use are not opened.
    out
        The record's folder, which must be empty or absent; by default a new one under `runs`.
    view
        Who shows the run while it goes on.
    watch
        Called with the runner before the first tick.
    devices
        Devices to use instead of a cell's, by the names that the tree declares; they are stopped at the end, not closed.
        Those of an open cell bring its clock, hand and limits.
    modules
        Folder in which the Python modules of the tree may stand; by default the folder of the tree.
    longest
        Virtual time, s or text with a unit, after which a run that nobody waits for ends with FAILURE; two hours by default.
    record
        What is kept of the run: `full`, `events` without what the devices read and without a report, or `none`.
    tolerance
        How far results of the twin may be from those with everything possible on, in the place of what the scene says of them: by name
        (`height`, `size`, `force`, `stiffness`, `roundness`) text such as `0.3 mm` or `2 %`, or an SI number. Of a run in which nothing
        is simulated, on mocks, or on an open cell, which has its scene already, it is refused.

    Raises
    ------
    FileError
        A file is wrong; nothing has moved.
    DeviceFault
        A device could not be opened; nothing has moved.
    """
    check_arguments(
        tree=tree,
        scene=scene,
        cell=cell,
        params=params,
        mocks=mocks,
        out=out,
        devices=devices,
        modules=modules,
        record=record,
        tolerance=tolerance,
    )
    longest = parse_time("longest", longest)
    _check_kept(record, out)
    bound = _asked_for(tolerance, mocks, cell, devices)
    given = _given(cell, devices, scene)
    if given is not None:
        scene = given.scene or scene
        if given.seed is not None and seed not in (0, given.seed):
            raise InvalidInput(f"an open cell has its seed, {given.seed}, already; write open_cell(..., seed={seed})")
        seed = seed if given.seed is None else given.seed
    named = cell if isinstance(cell, str | Path) else None
    task = task_of(tree, scene, named, dict(params or {}), seed, mocks, modules, given)
    task.tolerance = bound
    return execute(task, out, view, watch, given, longest, record)


def _check_kept(record: str, out: str | Path | None) -> None:
    if record not in KEPT:
        raise InvalidInput(
            f"record: {record!r} is none of {', '.join(KEPT)}; {did_you_mean(record, KEPT) or 'write full'}"
        )
    if record == "none" and out is not None:
        raise InvalidInput(f"{out}: no record is kept with record none; leave out the folder, or write record events")


def _asked_for(tolerance: Mapping[str, Any] | None, mocks: object, cell: object, devices: object) -> Tolerance | None:
    """Return the tolerance that a run asks for; raises InvalidInput for one that it cannot have."""
    if not tolerance:
        return None
    from stretch_bt.simulation.scene.asked import read_asked

    asked = read_asked(tolerance)
    why = "a tolerance bounds the twin, and"
    if mocks is not None:
        raise InvalidInput(f"{why} a run on mocks is none; leave out --tolerance, or --mocks")
    if devices is not None or not (cell is None or isinstance(cell, str | Path)):
        raise InvalidInput(f"{why} devices that are open already have theirs; leave out 'tolerance', or name a cell")
    return asked


def _given(
    cell: str | Path | OpenCell | None, devices: Mapping[str, Device] | None, scene: str | Path | None
) -> BorrowedDevices | None:
    """Return the devices that a caller gave; None where they are opened for the run."""
    if cell is not None and not isinstance(cell, str | Path):
        if devices is not None:
            raise InvalidInput("give an open cell or 'devices', not both: the cell has its own")
        if scene is not None:
            raise InvalidInput("an open cell has its scene already; open another cell for another scene")
        return cell.lend()
    if devices is None:
        return None
    from stretch_bt.runtime.borrowed_devices import borrow

    return borrow(devices)


def task_of(
    tree: str | Path,
    scene: str | Path | None,
    cell: str | Path | None,
    params: dict[str, Any],
    seed: int,
    mocks: str | Path | Mapping[str, Any] | None,
    modules: str | Path | None,
    given: BorrowedDevices | None = None,
) -> Task:
    """Return a run prepared, of what `run` takes, with the params that its scene asks for."""
    own = None if modules is None else Modules(Path(tree).parent.resolve(), Path(modules).resolve())

    def prepared(params: dict[str, Any]) -> Task:
        program = load_program(tree, params, own).require()
        if "main" not in program.document.trees:
            raise InvalidInput(f"{program.document.file} has no tree 'main'; it is a library for import")
        table = read_mocks(mocks, keep=True) if mocks is not None else None
        default = program.document.scene_path if cell is None and given is None else None
        made = Task(program, params, seed, str(scene or default or "") or None, str(cell) if cell else None, table)
        made.notes = [] if table is None else [str(found) for found in for_another(table, program)]
        return made

    task = prepared(params)
    if scene is not None and not _simulates(task, given):  # one that is named is read all the same
        from stretch_bt.simulation.scene import load_scene

        load_scene(scene)
    asked = _asked_of(task, given)
    return _with_asked(task, asked, prepared) if asked else task


def _simulates(task: Task, given: BorrowedDevices | None) -> bool:
    """Whether a run may simulate a scene that it names."""
    return bool(task.scene and (given is None or given.scene) and (task.cell or task.devices()))


def _asked_of(task: Task, given: BorrowedDevices | None) -> Mapping[Scalar, Scalar]:
    """Return the params that the scene of a run asks for, on mocks too; none where its cell is not simulated."""
    if given is not None:
        return given.scene_params
    if not task.scene:
        return {}
    asked = scene_params(str(task.scene))
    # few scenes ask for anything: only then is the cell looked at here as well
    return asked if asked and ((spec := task.cell_spec()) is None or spec.simulated) else {}


def _with_asked(task: Task, asked: Mapping[Scalar, Scalar], again: Callable[[dict[str, Any]], Task]) -> Task:
    """Return a task with the asked params that its tree has and the run does not set, and a note of each that the tree lacks.

    Raises
    ------
    SceneError
        A name that the tree does not have is nearly one that it has.
    """
    known = task.program.document.params
    strange = [key for key in asked if key.text not in known]
    wrong = [_unknown(key, known) for key in strange if closest(key.text, known, MISSPELT) is not None]
    if wrong:
        raise SceneError(wrong)
    taken = {k.text: v for k, v in asked.items() if k.text in known and k.text not in task.params}
    made = again({**task.params, **taken}) if taken else task
    made.notes += [str(replace(_unknown(key, known), severity="warning")) for key in strange]
    return made


def _unknown(key: Scalar, known: Iterable[str]) -> Diagnostic:
    hint = did_you_mean(key.text, known) if closest(key.text, known, MISSPELT) else "this run goes without it"
    return key.mark.error("param-unknown", f"params: the tree has no param {key.text!r}", hint)
