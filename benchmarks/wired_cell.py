"""A cell of stand-ins with all four wires, and the cost of its processes; used by the benchmarks that run tasks over it."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from stretch_bt import run
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.driver import OperatorDriver, Options, Poll
from stretch_bt.hardware.emulators.remote import Process
from stretch_bt.hardware.emulators.serve import Servers, serving_elsewhere
from stretch_bt.hardware.implementations import SHIPPED
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.monitored.arm import MonitoredArm

__all__ = ["WiredCell", "cpu", "own_host", "wired_cell"]

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
  operator: {type: Operator, use: agreeing}
limits: {depth: 30 mm, height: {min: 0 mm, max: 300 mm}}
"""


class Agreeing(OperatorDriver):
    """Agrees to whatever is asked, at once."""

    class Options(Options):
        """None."""

        type: Literal["Operator"]
        use: Literal["agreeing"]

    def mount(self, geometry: str, size: float) -> Poll:
        """Leave what is there."""
        return lambda: MotionState.DONE

    def confirm(self, request: str) -> Poll:
        """Agree."""
        return lambda: MotionState.DONE


SHIPPED["Operator", "agreeing"] = f"{__name__}:Agreeing"
#: where the hand of the simulated cell begins, m
_BEGIN = 0.12


@dataclass(frozen=True)
class WiredCell:
    """What is served, and the cell file that reaches it."""

    path: Path
    servers: Servers

    def run(self, tree: str, seed: int, record: str, **params: Any) -> tuple[Any, dict[str, float]]:
        """Run a task, and return its result and the part of a core that each process of the stand-ins took meanwhile."""
        before, begun = cpu(self.servers.processes), time.monotonic()
        result = run(tree, cell=self.path, seed=seed, out=record, params=params)
        seconds = time.monotonic() - begun
        return result, {name: (after - before[name]) / seconds for name, after in cpu(self.servers.processes).items()}

    def lower(self) -> None:
        """Take the hand to where the simulated cell's hand begins."""
        cell = open_cell(load_cell(self.path), now=time.monotonic, only={"arm"})
        try:
            arm = cell.devices["arm"]
            assert isinstance(arm, MonitoredArm)
            motion = arm.move(Pose((0.0, 0.0, _BEGIN)), speed=0.1, owner="benchmark")
            while motion.poll() is MotionState.MOVING:
                time.sleep(0.01)
        finally:
            cell.close()


@contextmanager
def wired_cell(
    folder: Path, scene: str, seed: int, *, model: str = "ur", host: str | None = None
) -> Iterator[WiredCell]:
    """Serve a cell around a scene, its hand where the simulated cell's begins; `host` is an address of this process's own."""
    host = host or own_host()
    path = folder / "wired.yaml"
    path.write_text(CELL.replace("HOST", host).replace("MODEL", "ur5" if model == "ur" else model))
    names = [model, "robotiq", "ati", "realsense"]
    with serving_elsewhere(names, scene=scene, seed=seed, host=host, activated=True, within=120.0) as servers:
        cell = WiredCell(path, servers)
        cell.lower()
        yield cell


def own_host() -> str:
    """Return an address of loopback that no other process takes."""
    return f"127.0.{64 + os.getpid() // 250 % 100}.{1 + os.getpid() % 250}"


def cpu(processes: Sequence[Process]) -> dict[str, float]:
    """Return the CPU time of processes so far, s, by name."""
    tick = os.sysconf("SC_CLK_TCK")
    fields = {p.name: Path(f"/proc/{p.pid}/stat").read_text().rpartition(")")[2].split() for p in processes}
    return {name: (int(found[11]) + int(found[12])) / tick for name, found in fields.items()}
