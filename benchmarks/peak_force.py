"""How hard the hand presses before the arm stands, measured on the stand-in's arm beside the computed force, and the answer of `check --cell`.

Run with `python benchmarks/peak_force.py [rounds] [ur|ur5e]`. The hand goes down at each speed onto a spring of each stiffness (the fault `wall`)
until the arm's limit of 20 N stops it; the measured force is the force while it stands, the largest of the rounds. The stand-in is in a
process of its own. A press that ends for another reason, as on a busy machine, is repeated and counted. A second table is of one stiffness over
a connection that holds readings back by almost `lost_after`.
"""

from __future__ import annotations

import itertools
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from arm_soak import open_arm

from stretch_bt import check
from stretch_bt.errors import DeviceFault
from stretch_bt.frames import Pose
from stretch_bt.hardware.emulators.control import control
from stretch_bt.hardware.emulators.serve import Served, serving_elsewhere
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.peak_force import PeakForce, peak_force
from stretch_bt.hardware.ur.arm import UrArm

HOST = "127.0.0.63"
SPEEDS = (5, 10, 20, 50, 100, 250)  # mm/s
STIFFNESSES = (1, 5, 20, 200)  # N/mm
WALL = 0.15
#: for which a connection holds readings back, s, of the 0.12 s after which it counts as lost
HELD_BACK = 0.1
#: how far above the wall the hand begins, m and m/(m/s)^2: it has its speed as it touches
ABOVE, RUN_UP = 0.004, 1.1
CELL = """\
format: stretch-cell/1
devices:
  arm: {{type: Arm, use: ur, host: 192.168.1.10, model: {model}, base: {{x: -500 mm}}, hand: {{z: 300 mm, rx: 180 deg}}, source: an example}}
limits: {{force: 20 N, stiffness: {stiffness} N/mm}}
"""
TREE = """\
format: stretch-tree/1
devices: {{arm: Arm}}
trees: {{main: {{roll: {{speed: {speed} mm/s}}}}}}
"""


class Robot:
    """A stand-in with its driver, which is opened anew for each press."""

    def __init__(self, served: Served, model: str) -> None:
        self._served, self._model = served, model
        self.again = 0

    def press(self, speed: float, stiffness: float, held_back: float = 0.0) -> float:
        """Return the force, N, at which the hand stands after it pressed at a speed, m/s, on a stiffness, N/m."""
        while True:
            self._do("clear")
            try:
                return self._pressed(speed, stiffness, held_back)
            except DeviceFault:
                self.again += 1

    def _pressed(self, speed: float, stiffness: float, held_back: float) -> float:
        arm = open_arm(self._model, HOST)
        try:
            until(arm, Pose((0.0, 0.0, WALL + ABOVE + RUN_UP * speed**2)), 0.25)
            self._do("inject", fault="wall", height=WALL, stiffness=stiffness)
            if held_back:
                self._do("inject", fault="late", delay=held_back)
                time.sleep(2 * held_back)
            try:
                until(arm, Pose((0.0, 0.0, 0.02)), speed)
            except DeviceFault as fault:
                if not fault.reason.startswith("force"):
                    raise
        finally:
            arm.close()
        return stiffness * max(WALL - self._rest(), 0.0)

    def _rest(self) -> float:
        """Return the height at which the hand stands for good, m."""
        while (state := self._state())["time"] < state["moved"] + 0.2:
            time.sleep(0.02)
        return float(state["height"])

    def _state(self) -> dict[str, Any]:
        [device] = self._do("list")["devices"].values()
        state: dict[str, Any] = device["state"]
        return state

    def _do(self, verb: str, **parameters: Any) -> dict[str, Any]:
        assert self._served.control is not None
        device = {"device": self._model} if verb == "inject" else {}
        return control(self._served.control, {"do": verb, **device, **parameters})


def until(arm: UrArm, target: Pose, speed: float) -> None:
    """Move the hand there."""
    poll = arm.follow([target], speed)
    while poll() is MotionState.MOVING:
        time.sleep(0.002)


def computed(model: str, speed: float, stiffness: float) -> PeakForce:
    """Return what is computed for a press."""
    options = UrArm.Options.model_validate(
        {
            "type": "Arm",
            "use": "ur",
            "host": HOST,
            "model": model,
            "base": {},
            "hand": {},
            "source": "the stand-in's own",
        }
    )
    limits = Limits()
    return peak_force(speed, stiffness, limits.force, options.stopping(limits))


def warned(model: str, speed: float, stiffness: float) -> bool:
    """Return whether `check --cell` warns of the speed, mm/s, on the stiffness, N/mm."""
    with tempfile.TemporaryDirectory() as folder:
        tree, cell = Path(folder) / "tree.yaml", Path(folder) / "cell.yaml"
        tree.write_text(TREE.format(speed=speed))
        cell.write_text(CELL.format(model=model, stiffness=stiffness))
        return any(finding.code == "cell-force" for finding in check(tree, cell=cell))


def main(rounds: int, stand_in: str) -> None:
    """Print both tables."""
    model = "ur5" if stand_in == "ur" else stand_in
    parts = []
    with serving_elsewhere([stand_in], host=HOST, control=0) as servers:
        robot = Robot(servers.served, stand_in)
        print("measured / computed, N; * check --cell warns\n")
        print("| speed, mm/s |" + "".join(f" {k} N/mm |" for k in STIFFNESSES))
        print("|---" * (1 + len(STIFFNESSES)) + "|")
        for speed in SPEEDS:
            print(f"| {speed} |", end="")
            for stiffness in STIFFNESSES:
                measured = max(robot.press(speed / 1e3, stiffness * 1e3) for _ in range(rounds))
                peak = computed(model, speed / 1e3, stiffness * 1e3).stopped
                parts.append(measured / peak)
                print(
                    f" {measured:.0f} / {peak:.0f}{' *' if warned(model, speed, stiffness) else ''} |",
                    end="",
                    flush=True,
                )
            print()
        print(
            f"\n| readings held back by {HELD_BACK:g} s, 20 N/mm, at mm/s |"
            + "".join(f" {speed} |" for speed in SPEEDS)
        )
        print("|---" * (1 + len(SPEEDS)) + "|\n| measured / computed, N |", end="")
        for speed, stiffness in itertools.product(SPEEDS, (20,)):
            measured = max(robot.press(speed / 1e3, stiffness * 1e3, HELD_BACK) for _ in range(rounds))
            peak = computed(model, speed / 1e3, stiffness * 1e3).late
            parts.append(measured / peak)
            print(f" {measured:.0f} / {peak:.0f} |", end="", flush=True)
        print(f"\n\nmeasured over computed: {min(parts):.2f} to {max(parts):.2f}; {robot.again} presses begun again")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3, sys.argv[2] if len(sys.argv) > 2 else "ur")
