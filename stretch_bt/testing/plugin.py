"""The pytest fixtures; installed with the package, imported only when a test asks for one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from stretch_bt.clock import VirtualClock
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.runtime.task import RunResult
    from stretch_bt.testing.scripted import ScriptedDevice
    from stretch_bt.testing.ticked_node import NodeResult
    from stretch_bt.testing.ticked_task import TickedTask


@pytest.fixture
def virtual_clock() -> VirtualClock:
    """A clock that a test moves."""
    from stretch_bt.clock import VirtualClock

    return VirtualClock()


@pytest.fixture
def cell(virtual_clock: VirtualClock) -> Iterator[Callable[..., Cell]]:
    """Open a cell on the virtual clock: `cell(scene="water_balloon", cell="simulated", seed=0)`."""
    from stretch_bt.hardware.cell import open_cell
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.simulation.scene import load_scene

    opened: list[Cell] = []

    def make(scene: str | Path = "water_balloon", cell: str | Path = "simulated", seed: int = 0) -> Cell:
        spec = load_cell(cell)
        world = load_scene(scene) if spec.simulated else None
        opened.append(open_cell(spec, clock=virtual_clock, seed=seed, scene=world))
        return opened[-1]

    yield make
    for each in opened:
        each.close()


@pytest.fixture
def run(tmp_path: Path, request: pytest.FixtureRequest) -> Callable[..., RunResult]:
    """Run a tree, given by name, path or YAML text, with its record in the test's own folder.

    A tree that is text stands for one beside the test: it may name Python modules there.
    `mocks` may be text or a mapping; scripted `devices`, by the names that the tree declares, take the time of the run.
    """
    from stretch_bt.runtime.task import run as run_tree

    trees = _Trees(tmp_path, request.path.parent)

    def make(tree: str | Path, **options: Any) -> RunResult:
        file, modules = trees.placed(tree)
        options.setdefault("out", tmp_path / f"record{trees.count}")
        options.setdefault("modules", modules)
        options["mocks"] = trees.beside(options.get("mocks"))
        return run_tree(file, **options)

    return make


@pytest.fixture
def tick_task(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Callable[..., TickedTask]]:
    """Begin a task that the test ticks: `tick_task(tree, mocks=None, devices=None)`, with trees, mocks and devices as `run` takes them.

    However the test ends, the task does so safely after it: its `finally` is run and its devices are stopped.
    """
    from stretch_bt.testing.ticked_task import TickedTask

    trees, begun = _Trees(tmp_path, request.path.parent), ExitStack()

    def make(tree: str | Path, *, mocks: Any = None, devices: Mapping[str, Any] | None = None) -> TickedTask:
        file, modules = trees.placed(tree)
        task = TickedTask(file, mocks=trees.beside(mocks), devices=devices, modules=modules, folder=tmp_path)
        begun.callback(task.close)
        return task

    with begun:
        yield make


@pytest.fixture
def tick_node(tmp_path: Path, request: pytest.FixtureRequest) -> Callable[..., NodeResult]:
    """Tick one node until it ends: `tick_node("measure_depth", touch=Touch(0.1, 0.0), arm=scripted_device("Arm"))`.

    Inputs are given by port: SI numbers, text with a unit, records, arrays, scripted devices. The result has `status`, `reason`, and
    the outputs as attributes. A node of one's own is found by its name, by `module.name` with the module beside the test, or by its class;
    a class of py_trees is one, too.
    """
    from stretch_bt.testing.node_named import node_info
    from stretch_bt.testing.ticked_node import tick_node as ticked

    def make(name: Any, /, **inputs: Any) -> NodeResult:
        return ticked(node_info(name, request.path.parent), inputs, tmp_path)

    return make


@pytest.fixture
def scripted_device(virtual_clock: VirtualClock) -> Callable[..., ScriptedDevice]:
    """Make a scripted device on the virtual clock: `scripted_device("Arm", {"wrench": [...]})`."""
    from stretch_bt.testing.scripted import ScriptedDevice

    def make(kind: str, script: Any = None, **options: Any) -> ScriptedDevice:
        return ScriptedDevice(kind, script or {}, now=virtual_clock.now, **options)

    return make


class _Trees:
    """Trees of a test: a shipped one by its name, a file from here or beside the test, or text, which stands for one beside the test."""

    def __init__(self, folder: Path, home: Path) -> None:
        self.folder, self.home = folder, home
        self.count = 0

    def placed(self, tree: str | Path) -> tuple[str | Path, Path | None]:
        """Return a name or path, and the folder in which modules of the tree may stand where that is not its own."""
        self.count += 1
        if not isinstance(tree, str) or "\n" not in tree:
            return self.beside(tree), None
        path = self.folder / f"tree{self.count}.yaml"
        path.write_text(tree, encoding="utf-8")
        return path, self.home

    def beside(self, given: Any) -> Any:
        """Return the path of a file that stands beside the test and not here; anything else as it is."""
        if not isinstance(given, str | Path) or "\n" in str(given):
            return given
        found = self.home / given
        return found if not Path(given).exists() and found.is_file() else given
