"""Palpation of the four balloons at `sheet` and at `hertz` fidelity, with the noise of the bench camera: result, frames and CPU time.

    python -m benchmarks.palpation_twin [--runs 3]

Each run is a process of its own, as a user starts it; the first of each scene, which may compile kernels, is left out. The CPU time is
for the whole task, with all that it imports on the way.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from importlib.resources import files
from pathlib import Path
from typing import Any

BALLOONS = ("air", "water", "pudding", "seeds")
FIDELITIES = {"sheet": "membrane", "hertz": "paper"}  # and the force model that is the twin's own


def main() -> None:
    """Print a line for each balloon and fidelity, and the difference between the two."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3)
    runs = parser.parse_args().runs
    print("balloon  fidelity  stiffness, N/mm    true   presses  frames  rendered  CPU s, median and most")
    for balloon in BALLOONS:
        means = [_row(balloon, fidelity, runs) for fidelity in FIDELITIES]
        print(f"{balloon:8} hertz differs from sheet by {100 * (means[1] / means[0] - 1):+.1f} %", flush=True)


def _row(balloon: str, fidelity: str, runs: int) -> float:
    found = [_palpated(balloon, fidelity, seed) for seed in (0, *range(runs))][1:]
    values = [r["outputs"]["stiffness"]["value"] for r in found]
    sds = [r["outputs"]["stiffness"]["sd"] for r in found]
    true = statistics.fmean(r["truth"]["stiffness"]["value"] for r in found)
    presses = statistics.fmean(r["outputs"]["presses"]["value"] for r in found)
    frames, rendered = (statistics.fmean(_count(r, name) for r in found) for name in ("correlated_noise", "render"))
    cpu = [r["cpu_seconds"] for r in found]
    print(
        f"{balloon:8} {fidelity:8}  {statistics.fmean(values):.3f} +- {statistics.fmean(sds):.3f}  {true:9.3f}  {presses:7.1f}  "
        f"{frames:6.0f}  {rendered:8.0f}  {statistics.median(cpu):.2f}, {max(cpu):.2f}",
        flush=True,
    )
    return statistics.fmean(values)


def _palpated(balloon: str, fidelity: str, seed: int) -> dict[str, Any]:
    shipped = files("stretch_bt") / "trees" / "scenes" / f"{balloon}_balloon.yaml"
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.yaml"
        scene.write_text(shipped.read_text("utf-8") + f"fidelity: {fidelity}\n", encoding="utf-8")
        command = [
            sys.executable,
            "-m",
            "stretch_bt",
            "run",
            "palpate_stiffness",
            "--scene",
            str(scene),
            "--json",
            "-q",
        ]
        command += [
            "--set",
            f"model={FIDELITIES[fidelity]}",
            "--stats",
            "--seed",
            str(seed),
            "--out",
            str(Path(folder) / "record"),
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    result: dict[str, Any] = json.loads(done.stdout)
    if result["status"] != "SUCCESS":
        raise SystemExit(f"{balloon} at {fidelity}, seed {seed}: {result['status']}: {result['reason']}")
    return result


def _count(result: dict[str, Any], name: str) -> int:
    return next((int(row["count"]) for row in result["stats"] if row["name"] == name), 0)


if __name__ == "__main__":
    main()
