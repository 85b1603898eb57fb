"""palpate_stiffness with all four devices over their real clients, beside the same on the simulated cell.

Run with `python benchmarks/palpate_wired.py [scene] [seed] [ur|ur5e]`. The stand-ins of a UR controller, a Robotiq gripper, a RealSense camera
and an ATI sensor act on one twin, in a process of their own; ur-rtde, pymodbus, librealsense and the RDT receiver speak to them. The wired run
takes as long as a robot would.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from arm_soak import open_arm

from stretch_bt import run
from stretch_bt.frames import Pose
from stretch_bt.hardware.emulators.remote import Process
from stretch_bt.hardware.emulators.serve import serving_elsewhere
from stretch_bt.hardware.interfaces import MotionState

HOST = "127.0.0.63"
CELL = """\
format: stretch-cell/1
devices:
  arm:
    type: Arm
    use: ur
    host: HOST
    model: MODEL
    base: {x: -500 mm}
    hand: {z: 300 mm, rx: 180 deg}
    source: the stand-in's own
    # stand-ins, clients and run share the cores of one machine, which may be busy for longer than a robot's deadlines
    watchdog: 1 Hz
    lost_after: 1 s
    heartbeat: 5 s
  gripper:
    type: Gripper
    use: robotiq
    host: HOST
    model: 2f140
    calibration: {points: [{count: 3, opening: 140 mm}, {count: 230, opening: 0 mm}], source: the stand-in's own}
  camera:
    type: DepthCamera
    use: realsense
    host: HOST
    lost_after: 2 s
  force_sensor:
    type: ForceSensor
    use: ati
    host: HOST
    calibration: {counts_per_newton: 1000000, counts_per_newton_metre: 1000000, source: the stand-in's own}
limits: {depth: 30 mm, height: {min: 0 mm, max: 300 mm}}
"""


def told(title: str, result: Any, seconds: float) -> None:
    """Print what a run found."""
    stiffness = result.outputs.get("stiffness", {})
    print(f"{title:10s}{result.status:9s} stiffness {stiffness.get('value')} +- {stiffness.get('sd')} {stiffness.get('unit')}, "
          f"task {result.task_seconds:.1f} s, wall {seconds:.1f} s, {result.ticks} ticks, {result.overruns} overruns {result.reason}",
          flush=True)  # fmt: skip


def lower(model: str) -> None:
    """Take the hand to where that of the simulated cell begins."""
    arm = open_arm(model, HOST, watchdog="1 Hz", lost_after="1 s", heartbeat="5 s")
    poll = arm.follow([Pose((0.0, 0.0, 0.12))], 0.1)
    while poll() is MotionState.MOVING:
        time.sleep(0.01)
    arm.close()


def simulated(scene: str, seed: int, record: str) -> Any:
    """Run on the simulated cell, and print what it found and what the scene knows."""
    begun = time.monotonic()
    result = run("palpate_stiffness", scene=scene, seed=seed, out=record)
    told("simulated", result, time.monotonic() - begun)
    print("truth", {name: estimate["value"] for name, estimate in result.truth.items()})
    return result


def wired(scene: str, seed: int, model: str, folder: str) -> Any:
    """Run over the wires, and print what it found, what went over the camera's and what the stand-ins took of a core."""
    path = Path(folder) / "wired.yaml"
    path.write_text(CELL.replace("HOST", HOST).replace("MODEL", "ur5" if model == "ur" else model))
    names = [model, "robotiq", "ati", "realsense"]
    with serving_elsewhere(names, scene=scene, seed=seed, host=HOST, activated=True, within=120.0) as servers:
        lower(model)
        before, begun = cpu(servers.processes), time.monotonic()
        result = run("palpate_stiffness", cell=path, seed=seed, out=f"{folder}/wired")
        seconds = time.monotonic() - begun
        told("wired", result, seconds)
        sent = servers.stand_ins["realsense"].state()
        print(f"{sent['sent']} frames came through librealsense, {sent['sent'] / seconds:.1f} a second, "
              f"{sent['late']} of them with a picture of a frame before")  # fmt: skip
        parts = {name: (after - before[name]) / seconds for name, after in cpu(servers.processes).items()}
        print(
            f"cores that the stand-ins took: {sum(parts.values()):.2f}, "
            + ", ".join(f"{n} {p:.3f}" for n, p in parts.items())
        )
    return result


def cpu(processes: Sequence[Process]) -> dict[str, float]:
    """Return the CPU time of processes so far, s, by name."""
    tick = os.sysconf("SC_CLK_TCK")
    fields = {p.name: Path(f"/proc/{p.pid}/stat").read_text().rpartition(")")[2].split() for p in processes}
    return {name: (int(found[11]) + int(found[12])) / tick for name, found in fields.items()}


def main(scene: str, seed: int, model: str) -> int:
    """Print both, and return the exit code of the wired run."""
    with tempfile.TemporaryDirectory() as folder:
        first = simulated(scene, seed, f"{folder}/simulated")
        second = wired(scene, seed, model, folder)
    over = second.task_seconds - first.task_seconds
    print(f"the wires took {over:+.1f} s of task time, {100 * over / first.task_seconds:+.0f} %")
    return {"SUCCESS": 0, "FAILURE": 1}.get(second.status, 3)


if __name__ == "__main__":
    given = sys.argv[1:] + ["water_balloon", "0", "ur"][len(sys.argv) - 1 :]
    sys.exit(main(given[0], int(given[1]), given[2]))
