"""A run being prepared: everything that is known before a device is opened."""

from __future__ import annotations

import math
import os
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stretch_bt.arguments import checked_seed
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.limits import Limits
from stretch_bt.plain_numbers import plain_list, plain_number
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.copies import named_by_originals
from stretch_bt.runtime.mocks import Mocks
from stretch_bt.runtime.prepare_nodes import prepare_nodes
from stretch_bt.runtime.provenance import choice_of, driver_modules, effects_on, machine, own_modules
from stretch_bt.source import Map, Scalar
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.build import build
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.document import Document
from stretch_bt.tree.program import Program

if TYPE_CHECKING:
    from stretch_bt.hardware.cell_file import CellSpec
    from stretch_bt.simulation.scene import Scene
    from stretch_bt.simulation.scene.sections import Tolerance

__all__ = ["VERSIONS", "Task", "versions"]

#: ticks of a run on mocks that does not say how many it expects: half an hour of the task at 50 Hz
MOCKED_TICKS = 100_000
DEFAULT_CELL = "simulated"
#: packages that results depend on
VERSIONS = ("stretch-bt", "py_trees", "numpy", "scipy", "numba", "opencv-contrib-python-headless", "pydantic")


@dataclass(slots=True)
class Task:
    """A run being prepared: everything that is known before a device is opened."""

    program: Program
    params: Mapping[str, Any]
    seed: int = 0
    scene: str | None = None
    cell: str | None = None
    mocks: Mocks | None = None
    #: tolerance of the twin's results, where the run asks for one
    tolerance: Tolerance | None = None
    notes: list[str] = field(default_factory=list)
    #: virtual time, s, after which the run is ended
    longest: float = math.inf
    context: RunContext = field(default_factory=RunContext)
    built: BuiltTree = field(init=False)

    def __post_init__(self) -> None:
        self.seed = checked_seed(self.seed)
        if self.mocks is not None:
            self.mocks.attach(self.context.mocked_readings)
        self.built = build(self.program, self.context, self.mocks)
        if self.mocks is not None:
            self.mocks.check_matches(self.built, self.program)

    def prepare(self, hand: Hand | None = None, limits: Limits | None = None) -> None:
        """Let every node look at the params, the hand and the limits of the cell before any device is opened."""
        self.context.about = self.header()
        self.context.hand, self.context.limits = hand or self.context.hand, limits
        prepare_nodes(self.built)

    def most_ticks(self) -> int | None:
        """Return after how many ticks a run on mocks is ended, as one of mocks that run for ever; None for any other run."""
        if self.mocks is None:
            return None
        expected = self.mocks.expect.ticks_max
        return MOCKED_TICKS if expected is None else 10 * expected

    def devices(self) -> set[str]:
        """Return the devices that the run needs: the devices of nodes and readings that are not mocked."""
        return self.built.needed(self.context.mocked_readings)

    def unmocked(self) -> list[str]:
        """Return what keeps a run on mocks from going without a cell: paths of nodes that use devices, and readings."""
        nodes = [path for path, node in self.built.nodes.items() if isinstance(node, Behavior) and node.device_names]
        return nodes + sorted(self.built.readings - self.context.mocked_readings.keys())

    def cell_spec(self) -> CellSpec | None:
        """Return the cell that the run opens, checked against what the tree declares; None when it needs none."""
        wanted = self.devices()
        if not wanted and self.cell is None:
            return None
        from stretch_bt.hardware.cell_file import load_cell
        from stretch_bt.runtime.reach import check_devices

        spec = load_cell(DEFAULT_CELL if self.cell is None else self.cell)
        check_devices(self.program, spec, wanted)
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
            "params": {name: _without_folder(param.value) for name, param in document.params.items()},
            "seed": self.seed,
            "scene": Path(self.scene).name if self.scene else None,
            "cell": Path(self.cell).name if self.cell else None,
            "mocks": Path(self.mocks.file).name if self.mocks else None,
            **({"tolerance": self.tolerance.named()} if self.tolerance is not None else {}),
            "tick": document.tick_period,
            "keys": outs,
            "versions": versions("stretch-bt", "py_trees", "numpy"),
        }

    def run_info(self, spec: CellSpec | None, scene: Scene | None = None, silent: Sequence[str] = ()) -> dict[str, Any]:
        """Return what a replay needs and what a person may want to know; `silent` are devices that report to no journal."""
        document, limits = self.program.document, self.context.limits
        info = {
            "tree": str(document.path.resolve()) if document.path else document.file,
            "sources": sources(self.program),
            "set": {k: _plain_param(v) for k, v in self.params.items()},
            "seed": self.seed,
            "scene": self.scene,
            "scene_text": _scene_text(self.scene) if scene is not None and self.scene else None,
            "effects": effects_on(scene),
            "tolerance": None if self.tolerance is None else self.tolerance.named(),
            "choice": choice_of(scene),
            "cell": self.cell,
            "cell_text": spec.path.read_text("utf-8") if spec is not None else None,
            "modules": own_modules(self.program),
            "simulated": _simulated(spec),
            "longest": None if math.isinf(self.longest) else self.longest,
            "driver_modules": driver_modules(spec),
            "hand": asdict(self.context.hand.geometry) if limits is not None else None,
            "limits": limits.model_dump() if limits is not None else None,
            "silent_devices": list(silent),
            "mocks": self.mocks.text if self.mocks else None,
            "started": datetime.now().astimezone().isoformat(timespec="seconds"),
            "host": platform.node(),
            "command": sys.argv,
            "python": platform.python_version(),
            "versions": versions(*VERSIONS),
            "machine": machine(compiled=spec is not None),
        }
        return dict(named_by_originals(info))


def _simulated(spec: CellSpec | None) -> list[str]:
    """Return the kinds of the devices that act on the scene alone."""
    devices = [] if spec is None else spec.devices.values()
    return sorted(device.type for device in devices if device.implementation.cls.simulated)


def _scene_text(scene: str) -> str:
    from stretch_bt.simulation.scene import scene_text

    return scene_text(scene)


def _plain_param(value: Any) -> Any:
    """Return a param as JSON takes it, so that a replay sets the same; one of a scene file is its text."""
    value = plain_list(plain_number(value))
    if isinstance(value, list | tuple):
        return [_plain_param(item) for item in value]
    if isinstance(value, float):  # an Estimate without its error, which no param has
        return float(value)
    if value is None or isinstance(value, int):
        return value
    return value.text if isinstance(value, Scalar) else str(value)


def _without_folder(value: Any) -> Any:
    """Return the value of a param; of text that is a path only the file's name, so that no log holds a place of the disk."""
    return Path(value).name if isinstance(value, str) and os.sep in value else value


def versions(*names: str) -> dict[str, str]:
    """Return the installed versions of packages."""
    return {name: _version(name) for name in names}


@cache
def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


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
