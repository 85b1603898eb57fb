"""Reconstruction in the twin: coverage, presses, robot time, error of the surface and of the dimensions.

    python -m benchmarks.reconstruct [--seeds 1] [--random 3] [--grid wooden_cube ...] [--keep rows.jsonl]

The shipped objects, with the shape that was found and the error of each graded dimension; then random convex polyhedra and
ellipsoids, as mesh files; then, for the scenes after --grid, the coarsest square grid of presses that covers as much with no
larger error. Coverage is the share of the upper surface, with normals within 45 degrees of the vertical, in whose cell of
1 mm a point of the cloud lies; `<0.5 mm` and `<1 mm` are the shares that the lowest membrane of any press bounds from above
to within that, touched or not; the error is the distance of the cloud's points from the true surface, root mean square over
cells of the whole cloud, what lies beyond an edge too, and over those with upper surface; `most N` is the largest force, of
the scene, while the hand stood pressed. With --keep each row is also added to a file, and those that it holds already of this
state of the package and the scene are printed from it, so that a long study can be taken up again.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt import run
from stretch_bt.errors import SceneError
from stretch_bt.perception.clouds.ply import points_of
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.runner import Runner
from stretch_bt.simulation.above import distances, upper_surface
from stretch_bt.simulation.scene import Scene, load_scene
from stretch_bt.sweep.package_digest import package_digest
from stretch_bt.sweep.rows import RowFile

SHIPPED = (
    "wooden_cube",
    "wooden_prism",
    "wooden_half_cylinder",
    "wooden_bridge",
    "glass_snowman",
    "paper_cube",
    "paper_half_cylinder",
    "paper_pyramid",
    "wire_circle",
    "wire_triangle",
)
HEAD = (
    "object                  coverage  <0.5 mm  <1 mm  stated   rms mm  upper mm  worst 5 %  height mm  presses  limited    most N  robot s   CPU s  "
    "shape: errors, mm (over their sd)"
)
GRIDS = (1, 2, 3, 4, 5)


@dataclass(frozen=True)
class Found:
    """What came of a run: shares, m, s."""

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

    def __str__(self) -> str:
        told = ", ".join(f"{name} {off:+.2f} ({off / sd:+.1f})" for name, (off, sd) in self.errors.items())
        return (
            f"{100 * self.coverage:8.1f}  {100 * self.bounds[0]:7.1f}  {100 * self.bounds[1]:5.1f}  {100 * self.stated:6.1f}"
            f"  {1e3 * self.rms:7.2f}  {1e3 * self.upper:8.2f}  {1e3 * self.worst:9.2f}"
            f"  {1e3 * self.height:+9.2f}  {self.presses:7d}  {self.limited:7d}  {self.force:8.3f}  {self.seconds:7.1f}  {self.cpu:6.1f}"
            f"  {self.shape}: {told}"
        )


def main() -> None:
    """Print a line for each object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--random", type=int, default=3)
    parser.add_argument("--scenes", nargs="*", default=list(SHIPPED))
    parser.add_argument("--grid", nargs="*", default=[])
    parser.add_argument("--keep", type=Path, help="file of rows, to begin or to go on with")
    given = parser.parse_args()
    rows = Rows(given.keep)
    print(HEAD, flush=True)
    found = [
        (name, rows.line(f"{name} {seed}", name, seed, {})) for seed in range(given.seeds) for name in given.scenes
    ]
    if given.seeds > 1:
        for name in given.scenes:
            _print_object(name, [of for which, of in found if which == name])
    for kind, make in (("polyhedron", _polyhedron), ("ellipsoid", _ellipsoid)):
        _print_random(kind, make, given.random, rows)
    for name in given.grid:
        _against_grid(name, rows)


class Rows:
    """What runs came to, in a file where there is one: those of the same code and scene are not run again."""

    def __init__(self, path: Path | None) -> None:
        self.file = None if path is None else RowFile(path)
        self.known: dict[str, Any] = {}
        if self.file is not None:
            self.known = {row["key"]: row["found"] for row in self.file.rows(iter([*self.file.statuses]))}

    def line(self, label: str, scene: str | Path, seed: int, params: Mapping[str, Any]) -> Found | str:
        """Print what came of a run, or why nothing did, and return it."""
        key = json.dumps([_state(), label, _scene_text(scene), seed, dict(params)])
        if key in self.known:
            known = self.known[key]
            found = known if isinstance(known, str) else Found(**known)
        else:
            found = reconstructed(scene, seed, params)
            self._keep(key, found)
        print(f"{label:22s}  {found}", flush=True)
        return found

    def _keep(self, key: str, found: Found | str) -> None:
        if self.file is not None:
            told = found if isinstance(found, str) else asdict(found)
            self.file.write({"key": key, "status": "SUCCESS", "found": told})


@cache
def _state() -> str:
    """Return a hash of the package, and of this file."""
    own = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
    return hashlib.sha256((package_digest() + own).encode()).hexdigest()[:16]


def _scene_text(scene: str | Path) -> str:
    """Return what a scene of a file says, or the name of a shipped one."""
    return scene.read_text(encoding="utf-8") if isinstance(scene, Path) else scene


def _print_object(name: str, found: list[Found | str]) -> None:
    """Print what came of an object over all seeds."""
    good = [f for f in found if isinstance(f, Found)]
    shapes = {shape: sum(f.shape == shape for f in good) for shape in sorted({f.shape for f in good})}
    print(f"{name}: {len(good)} of {len(found)} answered, {shapes}")
    if not good:
        return
    for dimension in sorted({key for f in good for key in f.errors}):
        offs, sds = np.array([f.errors[dimension] for f in good if dimension in f.errors]).T
        print(
            f"    {dimension}: mean absolute error {np.abs(offs).mean():.2f} mm, mean {offs.mean():+.2f}, largest {np.abs(offs).max():.2f}, "
            f"rms over its deviation {np.sqrt(np.mean((offs / sds) ** 2)):.2f}"
        )
    share, presses, force, cpu = np.array([(f.coverage, f.presses, f.force, f.cpu) for f in good]).T
    print(
        f"    coverage {100 * share.mean():.0f} %, least {100 * share.min():.0f}; presses {presses.mean():.1f}; most force {force.max():.2f} N; "
        f"CPU {np.median(cpu):.0f} s",
        flush=True,
    )


def _print_random(kind: str, make: Callable[[np.random.Generator], Any], count: int, rows: Rows) -> None:
    with tempfile.TemporaryDirectory() as folder:
        scenes = [_scene(Path(folder), f"{kind}{k}", make(np.random.default_rng(k))) for k in range(count)]
        kept = [rows.line(f"{kind} {k}", scene, k, {}) for k, scene in enumerate(scenes)]
    good = [f for f in kept if isinstance(f, Found)]
    if good:
        shares, errors, upper = np.array([(f.coverage, f.rms, f.upper) for f in good]).T
        print(
            f"{kind}: {len(good)} of {len(kept)} answered; coverage mean {100 * shares.mean():.1f} %, over 90 % in "
            f"{(shares > 0.9).sum()}; rms of the upper surface mean {1e3 * upper.mean():.2f} mm, under 1 mm in {(upper < 1e-3).sum()}, "
            f"of the whole cloud {1e3 * errors.mean():.2f} mm, {(errors < 1e-3).sum()}; "
            f"presses {np.mean([f.presses for f in good]):.1f}",
            flush=True,
        )


def _against_grid(name: str, rows: Rows) -> None:
    """Print how many presses a square grid takes to cover as much as the planned ones."""
    planned = rows.line(f"{name} 0", name, 0, {})
    if not isinstance(planned, Found):
        return
    spec = load_scene(name).object
    surface = upper_surface(spec)
    low, high = surface.places.min(axis=0), surface.places.max(axis=0)
    for count in GRIDS:
        lines = [(np.arange(count) + 0.5) / count * (b - a) + a for a, b in zip(low, high, strict=True)]
        poses = [f"{1e3 * x:.2f} mm; {1e3 * y:.2f} mm" for x in lines[0] for y in lines[1]]
        found = rows.line(f"{name} {count} x {count}", name, 0, {"poses": poses, "max_presses": count**2})
        if isinstance(found, Found) and found.coverage >= planned.coverage - 0.01 and found.rms <= 1.05 * planned.rms:
            break
    print(f"{name}: planned {planned.presses} presses, grid {count**2}", flush=True)


def reconstructed(scene: str | Path, seed: int, params: Mapping[str, Any]) -> Found | str:
    """Return what comes of a run against the scene's truth, or why nothing did."""
    began = time.process_time()
    known: Scene = load_scene(scene)
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "record"
        forces = _Forces()
        result = run("reconstruct", scene=scene, seed=seed, params=dict(params), out=record, watch=forces.follow)
        if result.status == "INTERRUPTED":
            raise SystemExit(result.reason)
        if result.status != "SUCCESS":
            return f"{result.status}: {result.reason[:150]}"
        points = points_of((record / "cloud.ply").read_bytes())
    off, above = distances(known.object, points), upper_surface(known.object)
    cells, there = _cells(points[:, :2]), _cells(above.places)
    lies, felt = (np.array([c in wanted for c in of]) for of, wanted in ((cells, set(there)), (there, set(cells))))
    x, y = above.places.T
    over = forces.relief.at(forces.relief.ceiling, x, y, np.inf) - above.heights

    def bounded(most: float) -> float:
        return float(above.areas[over < most].sum() / above.areas.sum())

    out = {name: value["value"] for name, value in result.outputs.items()}
    return Found(
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


def _cells(places: Any) -> list[tuple[int, ...]]:
    """Return the cells of 1 mm in which places (n, 2), m, lie."""
    return [tuple(cell) for cell in np.floor(places / 1e-3).astype(int).tolist()]


def _rms(off: Any, points: Any) -> float:
    """Return the root mean square over cells of 1 mm, as seen from above: what was felt has more points than what is told beside it."""
    _, which, count = np.unique(
        np.floor(points[:, :2] / 1e-3).astype(int), axis=0, return_inverse=True, return_counts=True
    )
    return float(np.sqrt(np.mean(np.bincount(which.ravel(), off**2) / count)))


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


def _polyhedron(random: np.random.Generator) -> Any:
    """Return the hull of 14 random points in a ball that is pressed flat, mm."""
    import trimesh

    points = random.normal(size=(14, 3))
    points *= (random.uniform(0.6, 1.0, size=14) ** (1 / 3) / np.linalg.norm(points, axis=1))[:, None]
    return trimesh.convex.convex_hull(points * random.uniform([18, 18, 11], [28, 28, 18]))


def _ellipsoid(random: np.random.Generator) -> Any:
    """Return the upper three quarters of an ellipsoid, mm."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=3)
    ball.apply_scale(random.uniform([16, 16, 12], [26, 26, 18]))
    return ball


def _scene(folder: Path, name: str, mesh: Any) -> Path:
    """Return the scene of a body, whose edges are rounded by a millimetre, or by less where it is thinner than two of these."""
    mesh.export(folder / f"{name}.stl")
    path = folder / f"{name}.yaml"
    for edge in (1, 0.5, 0.25, 0.1):
        _write_scene(path, name, edge)
        with suppress(SceneError):
            load_scene(path)
            break
    return path


def _write_scene(path: Path, name: str, edge: float) -> None:
    path.write_text(
        f"format: stretch-scene/1\nobject: {{type: mesh, file: {name}.stl, edge: {edge} mm, rigid: true}}\n"
        "tolerance: {height: 0.3 mm, size: 1 mm}\n"
        "conditions: {stretch: 0 mm, depth: 10 mm, hold: 0.5 s, speed: 0 mm/s, frames: 8, presses: 1, travel: 0 mm}\n",
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
