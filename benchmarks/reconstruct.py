"""Reconstruction in the twin: coverage, presses, robot time, error of the surface and of the dimensions.

    python -m benchmarks.reconstruct [--seeds 1] [--random 3] [--grid wooden_cube ...] [--keep rows.jsonl]

The shipped objects, with the shape that was found and the error of each graded dimension; then random convex polyhedra and
ellipsoids, as mesh files; then, for the scenes after --grid, the coarsest square grid of presses that covers as much with no
larger error. Coverage is the share of the upper surface, with normals within 45 degrees of the vertical, in whose cell of
1 mm a point of the cloud lies; `<0.5 mm` and `<1 mm` are the shares that the lowest membrane of any press bounds from above
to within that, touched or not; the error is the distance of the cloud's points from the true surface, root mean square over
cells of the whole cloud, with cells beyond an edge, and over the cells with upper surface; `most N` is the largest force, of
the scene, while the hand stood pressed. With --keep each row is also added to a file, and rows that it holds already of this
state of the package and the scene are printed from it, so that a long study can be taken up again.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import tempfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.accuracy.reconstruction.run import ReconstructionOutcome, Unfinished, grid, reconstructed
from stretch_bt.errors import SceneError
from stretch_bt.simulation.scene import load_scene
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


def line(found: ReconstructionOutcome | str) -> str:
    """Return what came of a run as text."""
    if isinstance(found, str):
        return found
    told = ", ".join(f"{name} {off:+.2f} ({off / sd:+.1f})" for name, (off, sd) in found.errors.items())
    return (
        f"{100 * found.coverage:8.1f}  {100 * found.bounds[0]:7.1f}  {100 * found.bounds[1]:5.1f}  {100 * found.stated:6.1f}"
        f"  {1e3 * found.rms:7.2f}  {1e3 * found.upper:8.2f}  {1e3 * found.worst:9.2f}"
        f"  {1e3 * found.height:+9.2f}  {found.presses:7d}  {found.limited:7d}  {found.force:8.3f}  {found.seconds:7.1f}  {found.cpu:6.1f}"
        f"  {found.shape}: {told}"
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
    """What runs came to, in a file where there is one: runs of the same code and scene are not repeated."""

    def __init__(self, path: Path | None) -> None:
        self.file = None if path is None else RowFile(path)
        self.known: dict[str, Any] = {}
        if self.file is not None:
            self.known = {row["key"]: row["found"] for row in self.file.rows(iter([*self.file.statuses]))}

    def line(self, label: str, scene: str | Path, seed: int, params: Mapping[str, Any]) -> ReconstructionOutcome | str:
        """Print what came of a run, or why nothing did, and return it."""
        key = json.dumps([_state(), label, _scene_text(scene), seed, dict(params)])
        if key in self.known:
            known = self.known[key]
            found = known if isinstance(known, str) else ReconstructionOutcome(**known)
        else:
            done = reconstructed(scene, seed, params)
            found = done.reason if isinstance(done, Unfinished) else done
            self._keep(key, found)
        print(f"{label:22s}  {line(found)}", flush=True)
        return found

    def _keep(self, key: str, found: ReconstructionOutcome | str) -> None:
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


def _print_object(name: str, found: list[ReconstructionOutcome | str]) -> None:
    """Print what came of an object over all seeds."""
    good = [f for f in found if isinstance(f, ReconstructionOutcome)]
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
    good = [f for f in kept if isinstance(f, ReconstructionOutcome)]
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
    if not isinstance(planned, ReconstructionOutcome):
        return
    for count in GRIDS:
        found = rows.line(f"{name} {count} x {count}", name, 0, {"poses": grid(name, count), "max_presses": count**2})
        if (
            isinstance(found, ReconstructionOutcome)
            and found.coverage >= planned.coverage - 0.01
            and found.rms <= 1.05 * planned.rms
        ):
            break
    print(f"{name}: planned {planned.presses} presses, grid {count**2}", flush=True)


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
