"""A balloon palpated by a protocol, with the scene's truth on the way."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

from stretch_bt.accuracy.palpation.protocols import LEVELS, OWN, PROTOCOLS
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.result import RunResult
from stretch_bt.runtime.runner import Runner
from stretch_bt.runtime.task import run
from stretch_bt.simulation.scene import load_scene

__all__ = ["PalpationTruth", "palpated", "watched"]


@dataclass
class PalpationTruth(Onlooker):
    """Notes the scene's truth: the force at each press' end, the error of each height that was seen, when the object was met."""

    runner: Runner
    top: float
    forces: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    touched: float | None = None

    def begin_tick(self, tick: int, time: float) -> None:
        """Note when the flat membrane first stands at the object's top."""
        if self.touched is None and self.runner.context.devices["arm"].pose(1.0).value.height <= self.top:
            self.touched = time

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Note it."""
        cell: Any = self.runner.cell
        if key.endswith("/pressed"):
            self.forces.append(cell.truth()["force"])
        elif "track_height" in path and key.endswith(("/height", "/seen")):
            self.errors.append(value - cell.truth()["height"])

    def falls(self) -> int:
        """Return at how many presses the force fell."""
        pairs = zip(self.forces, self.forces[1:], strict=False)
        return sum(after < before - max(0.02 * before, 0.01) for before, after in pairs)


def palpated(
    protocol: str, level: int, balloon: str, fidelity: str, seed: int, extra: Mapping[str, Any]
) -> tuple[RunResult, PalpationTruth]:
    """Return the result of a run with the params of LEVELS and `extra`, and the scene's truth on its way."""
    shipped = files("stretch_bt") / "trees" / "scenes" / f"{balloon}_balloon.yaml"
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.yaml"
        scene.write_text(shipped.read_text("utf-8") + f"fidelity: {fidelity}\n", encoding="utf-8")
        params = {**LEVELS[protocol][level], "model": OWN[fidelity], **extra}
        return watched(balloon, PROTOCOLS[protocol], scene=scene, seed=seed, params=params, out=Path(folder) / "record")


def watched(balloon: str, tree: str, **given: Any) -> tuple[RunResult, PalpationTruth]:
    """Run a tree on a scene of a balloon as `run` does, and return its result and the scene's truth on its way."""
    notes: list[PalpationTruth] = []

    def watch(runner: Runner) -> None:
        notes.append(PalpationTruth(runner, load_scene(f"{balloon}_balloon").object.top))
        runner.watchers.append(notes[0])

    return run(tree, watch=watch, **given), notes[0]
