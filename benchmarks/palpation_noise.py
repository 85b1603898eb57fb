"""palpate_stiffness under the noise of a depth camera: its error, its stated error, its seconds and its CPU time.

python benchmarks/palpation_noise.py [--seeds 10] [--fidelity hertz sheet] [--workers 1]

Spheres of 60 mm, as stiff as the four balloons, under all noise of the `bench` camera (white 0.05 mm, correlated 0.3 mm over
3 pixels and 0.6 from frame to frame, fixed pattern 0.5 mm, drift 0.2 mm/min, counts of 0.125 mm, 1 % dropouts, 0.1 % flying
pixels); friction and Mullins effect off. At sheet fidelity the error includes the force model's, which the column
`model` shows apart: force predicted over force. The runs are a sweep; CPU seconds are for a run alone, without what its
process imports and compiles before.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.sweep import sweep
from stretch_bt.sweep.engines import engine_of

SCENE = """format: stretch-scene/1
object: {{type: sphere, diameter: 60 mm, stiffness: {stiffness} N/mm}}
fidelity: {fidelity}
tolerance: {{stiffness: 5 %, height: 0.3 mm}}
conditions: {{depth: 15 mm, presses: 8}}
effects: {{white_noise: on, correlated_noise: on, fixed_pattern: on, drift: on, quantisation: on, dropout: on,
          flying_pixels: on, lens_distortion: off, friction: off, mullins: off}}
"""
BALLOONS = {"air": 0.4, "water": 0.9, "pudding": 1.3, "seeds": 1.9}  # N/mm
HEAD = (
    f"{'fidelity':8} {'balloon':8} {'ok':>6} {'bias':>7} {'rms':>7} {'err/sd':>7} {'drop':>9} {'model':>7} {'radius sd':>9} "
    f"{'presses':>7} {'task s':>7} {'CPU s':>6} {'most':>6}"
)


def palpated(fidelity: str, seeds: int, workers: int, folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of the runs at a fidelity, by the balloon, in the order of their seeds."""
    for name, stiffness in BALLOONS.items():
        (folder / f"{name}.yaml").write_text(SCENE.format(fidelity=fidelity, stiffness=stiffness), encoding="utf-8")
    scenes = ", ".join(f"{name}.yaml" for name in BALLOONS)
    file = folder / f"{fidelity}.yaml"
    file.write_text(
        f"format: stretch-sweep/1\ntree: palpate_stiffness\nscene: [{scenes}]\nseeds: {seeds}\n", encoding="utf-8"
    )
    engine = engine_of("local", workers, None) if workers > 1 else engine_of("serial", None, None)
    found = sweep(file, engine, out=folder / f"rows of {fidelity}")
    rows = [json.loads(line) for line in (found.folder / "rows.jsonl").read_text("utf-8").splitlines()]
    rows.sort(key=lambda row: row["seed"])
    return {name: [row for row in rows if row["scene"] == f"{name}.yaml"] for name in BALLOONS}


def row(fidelity: str, name: str, results: list[dict[str, Any]]) -> str:
    """Return a line of the table."""
    good = [r for r in results if r["status"] == "SUCCESS"]
    head = f"{fidelity:8} {name:8} {len(good):3}/{len(results):<2}"
    if not good:
        return head
    picks: tuple[Callable[[dict[str, Any]], float], ...] = (
        lambda r: r["outputs"]["stiffness"]["value"] / BALLOONS[name] - 1.0,
        lambda r: r["outputs"]["stiffness"]["sd"] / BALLOONS[name],
        lambda r: r["outputs"]["deflection"]["value"] - r["truth"]["deflection"]["value"],
        lambda r: r["outputs"]["force"]["value"] / r["truth"]["force"]["value"] - 1.0,
        lambda r: r["outputs"]["radius"]["value"] - 30.0,
    )
    value, sd, drop, force, size = (np.array([pick(r) for r in good]) for pick in picks)
    cpu = [r["cpu_seconds"] for r in good]
    presses = np.mean([r["outputs"]["presses"]["value"] for r in good])
    return (
        f"{head} {value.mean():7.1%} {rms(value):7.1%} {rms(value / sd):7.2f} {rms(drop):6.3f} mm {force.mean():7.1%} "
        f"{rms(size):6.2f} mm {presses:7.1f} {np.mean([r['task_seconds'] for r in good]):7.1f} {np.median(cpu):6.2f} {max(cpu):6.2f}"
    )


def rms(values: np.ndarray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    """Print the table, and why runs failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--fidelity", nargs="+", default=["hertz", "sheet"])
    parser.add_argument("--workers", type=int, default=1)
    chosen = parser.parse_args()
    print(HEAD)
    with tempfile.TemporaryDirectory() as name:
        for fidelity in chosen.fidelity:
            for balloon, results in palpated(fidelity, chosen.seeds, chosen.workers, Path(name)).items():
                print(row(fidelity, balloon, results), flush=True)
                for result in results:
                    if result["status"] != "SUCCESS":
                        print(f"    seed {result['seed']}: {result['status']}: {result['reason']}", flush=True)


if __name__ == "__main__":
    main()
