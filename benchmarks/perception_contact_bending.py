"""The curvature of a ball under a sheet that bends, with its stated deviation.

    python benchmarks/perception_contact_bending.py [--balls 60] [--first 0] [--keep FILE]

Balls of 5 to 40 mm, drawn evenly in the logarithm, are pressed by the twin up to four times, 1 to 14 mm deep, up to 2 mm off the middle,
half of them under a sheet that is not stretched, the others under one stretched by 3 to 60 mm; weight and bending are on. The mean of eight
frames is taken: without noise, with white noise of 0.3 mm, or with all noise of the `bench` camera but its fixed pattern. It prints, by
noise and stretch, the root mean square of error over stated deviation, the largest, the relative errors, and how many were refused.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np
from kept import kept

from stretch_bt.accuracy.twin.cell import Bench
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import Pose
from stretch_bt.perception import find_contact, fit_contact_sphere
from stretch_bt.simulation.scene import parse_scene

QUIET = "correlated_noise: off, fixed_pattern: off, drift: off, dropout: off, flying_pixels: off"
NOISES = {
    "none": f"white_noise: off, {QUIET}",
    "white": f"white_noise: {{sd: 0.3 mm}}, {QUIET}",
    "bench": "white_noise: on, correlated_noise: on, fixed_pattern: off, drift: off, dropout: on, flying_pixels: on",
}
FRAMES, SETTLE, LEVELS, STEEPEST = 8, 0.5, 4, 1.6  # of a radius, at most that deep


def felt(seed: int) -> list[dict[str, Any]]:
    """Return a row for each press of a ball: errors over its curvature, or why there is none."""
    random = np.random.default_rng([77, seed])
    radius = math.exp(random.uniform(math.log(5.0), math.log(40.0)))
    stretch = float(random.choice([0.0, random.uniform(3.0, 60.0)]))
    noise = str(random.choice(list(NOISES)))
    scene = parse_scene(
        f"format: stretch-scene/1\nobject: {{type: sphere, diameter: {2 * radius:.2f} mm, rigid: true}}\ncamera: bench\n"
        f"effects: {{bending: on, sag: on, friction: off, mullins: off, wrinkling: off, {NOISES[noise]}}}\n"
    )
    bench = Bench(scene, seed)
    bench.stretch(stretch * 1e-3)
    aside = random.uniform(-2e-3, 2e-3, 2)
    above = Pose((float(aside[0]), float(aside[1]), scene.object.top + 0.03))
    bench.go(above, 0.1)
    rows = []
    for depth in sorted(random.uniform(1.0, 14.0, LEVELS)):
        if depth < STEEPEST * radius:
            bench.go(above.at_height(scene.object.top - depth * 1e-3), 0.02)
            bench.time += SETTLE
            row = {"radius": radius, "stretch": stretch, "depth": float(depth), "noise": noise}
            rows.append(row | _answer(bench, radius * 1e-3))
    return rows


def _answer(bench: Bench, radius: float) -> dict[str, Any]:
    try:
        sphere = fit_contact_sphere(find_contact(bench.frame(FRAMES)))
    except NoAnswer as error:
        return {"reason": error.reason}
    return {"error": sphere.curvature * radius - 1.0, "sd": sphere.curvature_sd * radius}


def show(rows: list[dict[str, Any]]) -> None:
    """Print a line for each noise and kind of stretch."""
    print("noise  sheet   answers of  rms error/sd  largest   median |error|, %   median sd, %")
    for noise in NOISES:
        for sheet in ("slack", "taut"):
            each = [r for r in rows if r["noise"] == noise and (r["stretch"] == 0.0) == (sheet == "slack")]
            good = [r for r in each if "error" in r]
            if good:
                shares = np.array([r["error"] / r["sd"] for r in good])
                off = np.median([abs(r["error"]) for r in good])
                sd = np.median([r["sd"] for r in good])
                print(
                    f"{noise:6s} {sheet:6s} {len(good):5d} of {len(each):3d} {math.sqrt(float(np.mean(shares**2))):10.2f} "
                    f"{np.abs(shares).max():10.1f} {100 * off:15.1f} {100 * sd:17.1f}"
                )


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--balls", type=int, default=60)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--keep", type=Path, help="file of rows, to begin or to go on with")
    given = parser.parse_args()
    seeds = [(given.first + k,) for k in range(given.balls)]
    show([row for _, rows in kept(felt, seeds, given.keep) for row in rows])


if __name__ == "__main__":
    main()
