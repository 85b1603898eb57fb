"""A run of `reconstruct` in the twin, and its errors against the scene's truth."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.perception.cells import cells_of
from stretch_bt.perception.clouds.ply import points_of
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.result import RunResult
from stretch_bt.runtime.runner import Runner
from stretch_bt.runtime.task import run
from stretch_bt.simulation.above import distances, upper_surface
from stretch_bt.simulation.scene import Scene, load_scene

__all__ = ["ReconstructionOutcome", "Unfinished", "grid", "reconstructed"]


@dataclass(frozen=True)
class ReconstructionOutcome:
    """The outcome of a run: shares, m, s; `errors` of the graded dimensions in mm, with their deviations."""

    coverage: float
    stated: float
    rms: float
    upper: float
    worst: float
    height: float
    presses: int
    limited: int
    force: float
    seconds: float
    cpu: float
    shape: str
    bounds: tuple[float, float]
    errors: dict[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Unfinished:
    """A run that found nothing, and why; times in s."""

    reason: str
    seconds: float
    cpu: float

    def __str__(self) -> str:
        return self.reason


def reconstructed(scene: str | Path, seed: int, params: Mapping[str, Any]) -> ReconstructionOutcome | Unfinished:
    """Return the outcome of a run against the scene's truth, or why there is none."""
    began = time.process_time()
    known: Scene = load_scene(scene)
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "record"
        forces = _Forces()
        result = run("reconstruct", scene=scene, seed=seed, params=dict(params), out=record, watch=forces.follow)
        if result.status == "INTERRUPTED":  # the runner takes the signal for itself
            raise KeyboardInterrupt
        if result.status != "SUCCESS":
            return Unfinished(
                f"{result.status}: {result.reason[:150]}", result.task_seconds, time.process_time() - began
            )
        points = points_of((record / "cloud.ply").read_bytes())
    return _graded(known, result, points, forces, began)


def _graded(known: Scene, result: RunResult, points: Any, forces: _Forces, began: float) -> ReconstructionOutcome:
    """Return the errors of a run that ended well, with its cloud (n, 3), m; `began` is the CPU time, s, at its begin."""
    off, above = distances(known.object, points), upper_surface(known.object)
    cells, there = _cells(points[:, :2]), _cells(above.places)
    lies, felt = (np.array([c in wanted for c in of]) for of, wanted in ((cells, set(there)), (there, set(cells))))
    x, y = above.places.T
    over = forces.relief.at(forces.relief.ceiling, x, y, np.inf) - above.heights

    def bounded(most: float) -> float:
        return float(above.areas[over < most].sum() / above.areas.sum())

    out = {name: value["value"] for name, value in result.outputs.items()}
    return ReconstructionOutcome(
        coverage=float(above.areas[felt].sum() / above.areas.sum()),
        stated=out["coverage"],
        rms=_rms(off, points),
        upper=_rms(off[lies], points[lies]),
        worst=float(np.percentile(np.abs(off), 95)),
        height=1e-3 * out["top"] - known.object.top,
        presses=out["presses"],
        limited=out["limited"],
        force=max(forces.found),
        seconds=out["robot_time"],
        cpu=time.process_time() - began,
        shape=out["shape"],
        errors={
            name: (out[name] - truth["value"], result.outputs[name]["sd"])
            for name, truth in result.truth.items()
            if name in known.dimensions
        },
        bounds=(bounded(0.5e-3), bounded(1e-3)),
    )


def grid(scene: str, count: int) -> list[str]:
    """Return the poses, as `poses` takes them, of count x count presses over the outline of a scene's object."""
    surface = upper_surface(load_scene(scene).object)
    low, high = surface.places.min(axis=0), surface.places.max(axis=0)
    lines = [(np.arange(count) + 0.5) / count * (b - a) + a for a, b in zip(low, high, strict=True)]
    return [f"{1e3 * x:.2f} mm; {1e3 * y:.2f} mm" for x in lines[0] for y in lines[1]]


def _cells(places: Any) -> list[tuple[int, ...]]:
    """Return the cells of 1 mm in which places (n, 2), m, lie."""
    return [tuple(cell) for cell in np.floor(places / 1e-3).astype(int).tolist()]


def _rms(off: Any, points: Any) -> float:
    """Return the root mean square over cells of 1 mm, as seen from above: felt places have more points than the places beside them."""
    return float(np.sqrt(np.mean(cells_of(np.floor(points[:, :2] / 1e-3).astype(np.int64)).means(off**2))))


class _Forces(Onlooker):
    """The scene's own force, N, whenever the hand stands pressed, and the map as it was last."""

    relief: Relief

    def __init__(self) -> None:
        self.found: list[float] = []

    def follow(self, runner: Runner) -> None:
        """Watch a run."""
        self.cell: Any = runner.cell  # the twin's
        runner.watchers.append(self)

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Note them."""
        if isinstance(value, Relief):
            self.relief = value
        if path.endswith(("approach", "press_gently", "average_frames")):
            self.found.append(self.cell.truth()["force"])
