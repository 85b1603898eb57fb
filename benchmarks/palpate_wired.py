"""palpate_stiffness with arm, gripper and force sensor over their wires, beside the same on the simulated cell.

Run with `python benchmarks/palpate_wired.py [scene] [seed] [ur|ur5e]`. The stand-ins of a UR controller, a Robotiq gripper and an ATI sensor act on
one twin; ur-rtde, pymodbus and the RDT receiver speak to them. The camera is no wire yet: it renders the same twin in this process, at the
place that the stand-in's arm had at the exposure. The wired run takes as long as a robot would.
"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from arm_soak import open_arm

from stretch_bt import run
from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.hardware.driver import Bench, Options
from stretch_bt.hardware.emulators.serve import serving
from stretch_bt.hardware.emulators.stage import Stage
from stretch_bt.hardware.implementations import IMPLEMENTATIONS
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.simulated.camera import SimulatedCamera
from stretch_bt.simulation.scene import load_scene

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
    # everything runs in this process, whose interpreter may be busy for longer than a robot's deadlines
    watchdog: 1 Hz
    lost_after: 1 s
    heartbeat: 5 s
  gripper:
    type: Gripper
    use: robotiq
    host: HOST
    model: 2f140
    calibration: {points: [{count: 3, opening: 140 mm}, {count: 230, opening: 0 mm}], source: the stand-in's own}
  force_sensor:
    type: ForceSensor
    use: ati
    host: HOST
    calibration: {counts_per_newton: 1000000, counts_per_newton_metre: 1000000, source: the stand-in's own}
  camera: {type: DepthCamera, use: stage}
limits: {depth: 30 mm, height: {min: 0 mm, max: 300 mm}}
"""
stages: list[Stage] = []


class _Options(Options):
    type: Literal["DepthCamera"]
    use: Literal["stage"]
    rate: float = 30.0
    image: str = "membrane"


class StageCamera(SimulatedCamera):
    """Sees the twin that the stand-ins act on."""

    Options = _Options  # type: ignore[assignment]
    simulated = False

    def __init__(self, name: str, options: Any, bench: Bench) -> None:
        stage = stages[-1]
        seen = Bench(stage.now, bench.seed, bench.root, bench.hand, bench.limits)
        seen.__dict__["twin"] = stage.twin
        super().__init__(name, options, seen)
        self._stage, self._now = stage, bench.now

    def frame(self) -> Reading[DepthFrame]:
        """Return the latest frame, at the time of the run's clock."""
        with self._stage.lock:
            reading = super().frame()
        return replace(reading, host_time=reading.host_time + self._now() - self._stage.now())


def told(title: str, result: Any, seconds: float) -> None:
    """Print what a run found."""
    stiffness = result.outputs.get("stiffness", {})
    print(f"{title:10s}{result.status:9s} stiffness {stiffness.get('value')} +- {stiffness.get('sd')} {stiffness.get('unit')}, "
          f"task {result.task_seconds:.1f} s, wall {seconds:.1f} s, {result.ticks} ticks, {result.overruns} overruns {result.reason}",
          flush=True)  # fmt: skip


def lower(model: str) -> None:
    """Take the hand to where that of the simulated cell begins."""
    arm = open_arm(model, HOST)
    poll = arm.follow([Pose((0.0, 0.0, 0.12))], 0.1)
    while poll() is MotionState.MOVING:
        time.sleep(0.01)
    arm.close()


def main(scene: str, seed: int, model: str) -> None:
    """Print both."""
    IMPLEMENTATIONS["DepthCamera", "stage"] = f"{__name__}:StageCamera"
    sys.modules.setdefault("palpate_wired", sys.modules[__name__])
    with tempfile.TemporaryDirectory() as folder:
        begun = time.monotonic()
        told(
            "simulated",
            run("palpate_stiffness", scene=scene, seed=seed, out=f"{folder}/simulated"),
            time.monotonic() - begun,
        )
        stage = Stage(load_scene(scene), seed=seed)
        stages.append(stage)
        path = Path(folder) / "wired.yaml"
        path.write_text(CELL.replace("HOST", HOST).replace("MODEL", "ur5" if model == "ur" else model))
        with serving([model, "robotiq", "ati"], stage, host=HOST, activated=True):
            lower(model)
            begun = time.monotonic()
            told(
                "wired", run("palpate_stiffness", cell=path, seed=seed, out=f"{folder}/wired"), time.monotonic() - begun
            )
        print("truth", stage.twin.truth() if stage.twin is not None else None)


if __name__ == "__main__":
    given = sys.argv[1:] + ["water_balloon", "0", "ur"][len(sys.argv) - 1 :]
    main(given[0], int(given[1]), given[2])
