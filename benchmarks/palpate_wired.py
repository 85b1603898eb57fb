"""palpate_stiffness with all four devices over their real clients, beside the same on the simulated cell.

Run with `python benchmarks/palpate_wired.py [scene] [seed] [ur|ur5e]`. The stand-ins of a UR controller, a Robotiq gripper, a RealSense camera
and an ATI sensor act on one twin, each in a process of its own; ur-rtde, pymodbus, librealsense and the RDT receiver speak to them. The wired
run takes as long as a robot would, and the command exits by the end of the wired run.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from wired_cell import wired_cell

from stretch_bt import run

ENDS = {"SUCCESS": 0, "FAILURE": 1, "FAULT": 3, "INTERRUPTED": 130}


def told(title: str, result: Any, seconds: float) -> None:
    """Print what a run found."""
    stiffness = result.outputs.get("stiffness")
    found = "no stiffness" if stiffness is None else f"stiffness {stiffness['value']:.4f} +- {stiffness['sd']:.4f} N/mm"
    print(f"{title:10s}{result.status:9s} {found}, task {result.task_seconds:.1f} s, wall {seconds:.1f} s, {result.ticks} ticks, "
          f"{result.overruns} overruns {result.reason}", flush=True)  # fmt: skip


def simulated(scene: str, seed: int, record: str) -> Any:
    """Run on the simulated cell, and print what it found and the scene's truth."""
    begun = time.monotonic()
    result = run("palpate_stiffness", scene=scene, seed=seed, out=record)
    told("simulated", result, time.monotonic() - begun)
    print(
        "truth",
        {name: f"{estimate['value']:.4g} {estimate['unit']}".strip() for name, estimate in result.truth.items()},
    )
    return result


def wired(scene: str, seed: int, model: str, folder: str) -> Any:
    """Run over the wires, and print what it found, what went over the camera's and what the stand-ins took of a core."""
    with wired_cell(Path(folder), scene, seed, model=model) as cell:
        begun = time.monotonic()
        result, cores = cell.run("palpate_stiffness", seed, f"{folder}/wired")
        told("wired", result, time.monotonic() - begun)
        sent = cell.servers.stand_ins["realsense"].state()
        print(f"{sent['sent']} frames came through librealsense, {sent['sent'] / result.task_seconds:.1f} a second of the task, "
              f"{sent['late']} of them with the picture of one before")  # fmt: skip
        print(
            f"the stand-ins took {sum(cores.values()):.2f} cores: "
            + ", ".join(f"{n} {p:.3f}" for n, p in cores.items())
        )
    return result


def main(scene: str, seed: int, model: str) -> int:
    """Print both, and return the exit code of the wired run."""
    with tempfile.TemporaryDirectory() as folder:
        first = simulated(scene, seed, f"{folder}/simulated")
        second = wired(scene, seed, model, folder)
    over = second.task_seconds - first.task_seconds
    print(f"the wires took {over:+.1f} s of task time, {100 * over / first.task_seconds:+.0f} %")
    return ENDS.get(second.status, 2)


if __name__ == "__main__":
    given = sys.argv[1:] + ["water_balloon", "0", "ur"][len(sys.argv) - 1 :]
    sys.exit(main(given[0], int(given[1]), given[2]))
