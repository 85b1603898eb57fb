"""Errors of the graded dimensions of the shipped scenes, by presses around each object; no tree, no planning.

    python -m benchmarks.dimensions [seeds] [scene ...]

Five presses a scene with the noise of the bench camera, at stretch 0, 10 mm deep (12 mm on the snowman, 6 mm on paper, 8 mm on its
pyramid, whose walls would buckle), 24 frames each. `error` is the mean absolute one, `worst` the largest, `stated` the mean standard
deviation, `error/sd` the root mean square of their ratio, and `membrane` and `table` are the corrections by these steps; mm.
"""

from __future__ import annotations

import sys
import time
from collections import Counter, defaultdict

import numpy as np

from stretch_bt.accuracy.twin.felt import around, felt, fused
from stretch_bt.errors import NoAnswer, NoEquilibrium
from stretch_bt.perception import Dimension, Solid, fit_object
from stretch_bt.simulation.scene import load_scene

MM = 1e3
DEPTHS = {
    "wooden_cube": 0.010,
    "wooden_prism": 0.010,
    "wooden_half_cylinder": 0.010,
    "wooden_bridge": 0.010,
    "glass_snowman": 0.012,
    "paper_cube": 0.006,
    "paper_half_cylinder": 0.006,
    "paper_pyramid": 0.008,
    "wire_circle": 0.010,
    "wire_triangle": 0.010,
}
DOMES = [(-0.019, 0.0), (0.006, 0.0), (0.025, 0.0), (-0.006, 0.0), (0.015, 0.0)]


def measured(name: str, seed: int) -> Solid:
    """Return the shape of what a scene holds."""
    scene = load_scene(name)
    places = DOMES if name == "glass_snowman" else around(scene)
    contacts = felt(scene, seed, places, DEPTHS[name])
    return fit_object(fused(contacts), contacts)


def main() -> None:
    """Print a line of each scene and dimension."""
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    print(
        "scene                 dimension     truth   error   worst  stated  error/sd  membrane    table  found, seconds"
    )
    for name in sys.argv[2:] or DEPTHS:
        rows(name, seeds)


def rows(name: str, seeds: int) -> None:
    """Print the lines of a scene."""
    found: dict[str, list[Dimension]] = defaultdict(list)
    kinds: Counter[str] = Counter()
    graded = load_scene(name).dimensions
    begin = time.process_time()
    for seed in range(seeds):
        try:
            solid = measured(name, seed)
        except (NoAnswer, NoEquilibrium) as error:
            kinds[f"refused ({error})"] += 1
            continue
        kinds[solid.kind] += 1
        for dimension in graded:
            if dimension in solid.dimensions:
                found[dimension].append(solid.dimensions[dimension])
    told = ", ".join(f"{kind} {count}" for kind, count in kinds.most_common())
    told += f", {(time.process_time() - begin) / seeds:.0f} s"
    for dimension, truth in graded.items():
        print(_row(name, dimension, truth, found[dimension], seeds) + f"  {told}", flush=True)


def _row(name: str, dimension: str, truth: float, found: list[Dimension], seeds: int) -> str:
    head = f"{name:20s}  {dimension:9s} {truth * MM:8.2f}"
    if not found:
        return f"{head}  found in none of {seeds}"
    error = np.array([d.value - truth for d in found])
    sd = np.array([d.sd for d in found])
    steps = [np.mean([d.steps.get(step, 0.0) for d in found]) * MM for step in ("membrane", "table")]
    missed = f" (of {seeds}: {len(found)})" if len(found) < seeds else ""
    return (
        f"{head} {np.abs(error).mean() * MM:7.2f} {np.abs(error).max() * MM:7.2f} {sd.mean() * MM:7.2f}"
        f" {np.sqrt(np.mean((error / sd) ** 2)):9.2f} {steps[0]:+9.2f} {steps[1]:+8.2f}{missed}"
    )


if __name__ == "__main__":
    main()
