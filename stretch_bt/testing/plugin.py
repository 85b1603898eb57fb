"""The pytest fixtures; installed with the package, imported only when a test asks for one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from stretch_bt.clock import VirtualClock
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.runtime.task import RunResult
    from stretch_bt.testing.scripted import ScriptedDevice


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

    count = 0

    def written(given: str | Path) -> str | Path:
        if not isinstance(given, str) or "\n" not in given:
            return given
        path = tmp_path / f"tree{count}.yaml"
        path.write_text(given, encoding="utf-8")
        return path

    def make(tree: str | Path, **options: Any) -> RunResult:
        nonlocal count
        count += 1
        options.setdefault("out", tmp_path / f"record{count}")
        file = written(tree)
        if file is not tree:
            options.setdefault("modules", request.path.parent)
        return run_tree(file, **options)

    return make


@pytest.fixture
def scripted_device(virtual_clock: VirtualClock) -> Callable[..., ScriptedDevice]:
    """Make a scripted device on the virtual clock: `scripted_device("Arm", {"wrench": [...]})`."""
    from stretch_bt.testing.scripted import ScriptedDevice

    def make(kind: str, script: Any = None, **options: Any) -> ScriptedDevice:
        return ScriptedDevice(kind, script or {}, now=virtual_clock.now, **options)

    return make
