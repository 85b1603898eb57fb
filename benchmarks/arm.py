"""What an arm costs over its wires, and how each fault of its controller ends a motion, on loopback.

Run with `python benchmarks/arm.py [rounds] [ur|ur5e]`. Each fault comes while the hand goes down at 50 mm/s. `known` is the longest time
until the motion reported it, by this machine's clock; `moved` the longest time for which the hand went on, by the controller's clock, and
`way` the longest way, mm. After each fault the arm is opened anew and moved again; `lost` counts how often it does not come back.
"""

from __future__ import annotations

import itertools
import os
import signal
import statistics
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from arm_soak import go_on, open_arm

from stretch_bt.errors import DeviceFault
from stretch_bt.frames import Pose
from stretch_bt.hardware.driver import Poll
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn, Ur5StandIn
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.ur.arm import UrArm

HOST = "127.0.0.62"
HIGH, LOW = Pose((0.0, 0.0, 0.2)), Pose((0.0, 0.0, 0.1))
SPEED = 0.05
PARAMETERS: dict[str, dict[str, float]] = {
    "slow": {"rate": 1.0},
    "late": {"delay": 1.0},
    "garbage": {"bytes": 300},
    "protective_stop": {"locked": 0.2},
    "slider": {"fraction": 0.05},
    "load": {"fz": 30.0},
    "wall": {"height": 0.18, "stiffness": 20000.0},
}
#: of a controller that is opened, or no fault of a motion
OTHERS = {"registers", "local", "loss"}


def until(poll: Poll) -> MotionState:
    """Wait for the end of a motion."""
    while (state := poll()) is MotionState.MOVING:
        time.sleep(0.002)
    return state


def cpu(pid: int) -> float:
    """Return CPU time of a process, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def motions(arm: UrArm, rounds: int) -> None:
    """Print what motions take beside what they should, and what they cost."""
    here, there = time.process_time(), cpu(arm.process or 0)
    begun, walls, errors = time.monotonic(), [], []
    for target in itertools.islice(itertools.cycle([Pose((0, 0, 0.15)), HIGH]), 2 * rounds):
        try:
            start = time.monotonic()
            until(arm.follow([target], SPEED))
        except DeviceFault as fault:
            print(f"  unasked: {fault}", flush=True)
            go_on(arm)
            continue
        walls.append(time.monotonic() - start)
        errors.append(abs(arm.pose().value.height - target.height))
    spent = time.monotonic() - begun
    ideal = 0.05 / SPEED + SPEED / 0.5
    print(f"50 mm at 50 mm/s: {statistics.median(walls):.3f} s, at most {max(walls):.3f} s, of {ideal:.3f} s; "
          f"ends {1e6 * max(errors):.0f} um off at most")  # fmt: skip
    print(f"CPU: driver's process {100 * (cpu(arm.process or 0) - there) / spent:.0f} % of a core, "
          f"this process with the stand-in {100 * (time.process_time() - here) / spent:.0f} %")  # fmt: skip


def under_way(arm: UrArm, stand_in: Ur5StandIn) -> Poll:
    """Return a motion downwards that has its speed; where this machine is too busy for it, it is begun again."""
    while True:
        try:
            until(arm.follow([HIGH], 0.2))
            poll = arm.follow([LOW], SPEED)
            while stand_in.state()["speed"] < 0.9 * SPEED:
                poll()
                time.sleep(0.002)
        except DeviceFault as fault:
            print(f"  unasked: {fault}", flush=True)
            go_on(arm)
        else:
            return poll


def ended(arm: UrArm, stand_in: Ur5StandIn, cause: Callable[[], None]) -> tuple[float, float, float, str]:
    """Return how a cause ends a motion: time until the report, s, time and way for which the hand went on, s and m, and the reason given."""
    poll = under_way(arm, stand_in)
    begun, before = time.monotonic(), stand_in.state()
    cause()
    said = "nothing"
    while time.monotonic() < begun + 5:
        try:
            if poll() is not MotionState.MOVING:
                break
        except DeviceFault as fault:
            said = fault.reason
            break
        time.sleep(0.002)
    told = time.monotonic() - begun
    while stand_in.state()["moving"]:
        time.sleep(0.005)
    time.sleep(0.3)
    after = stand_in.state()
    return told, max(after["moved"] - before["time"], 0.0), before["height"] - after["height"], said


def faults(arm: UrArm, stand_in: Ur5StandIn, rounds: int) -> None:
    """Print how each fault ends a motion."""
    print(f"{'fault':18s}{'rounds':>7s}{'known, s':>9s}{'moved, s':>9s}{'way, mm':>9s}{'lost':>6s}  said at last")
    causes: dict[str, Callable[[], None]] = {
        name: partial(stand_in.inject, name, PARAMETERS.get(name)) for name in stand_in.FAULTS if name not in OTHERS
    }
    causes["kill -9 of driver"] = lambda: os.kill(arm.process or 0, signal.SIGKILL)
    causes["tick of 1.6 s"] = lambda: time.sleep(1.6)
    causes["hang of driver"] = lambda: os.kill(arm.process or 0, signal.SIGSTOP)
    for name, cause in causes.items():
        rows, lost = [], 0
        for _ in range(rounds):
            rows.append(ended(arm, stand_in, cause))
            stand_in.clear()
            if name == "wall":
                stand_in.inject("wall", {"height": 0.0})
            time.sleep(0.1)
            stand_in.controller.release_brakes()
            try:
                go_on(arm)
            except SystemExit:
                lost += 1
        told, moved, way = (max(numbers) for numbers in zip(*(row[:3] for row in rows), strict=True))
        print(f"{name:18s}{rounds:7d}{told:9.3f}{moved:9.3f}{1e3 * way:9.1f}{lost:6d}  {rows[-1][3][:60]}", flush=True)


def main(rounds: int, model: str) -> None:
    """Print all."""
    stand_in = {"ur": Ur5StandIn, "ur5e": Ur5eStandIn}[model](HOST, StandInWorld())
    stand_in.start()
    begun = time.monotonic()
    arm = open_arm(model, HOST)
    print(f"opened in {time.monotonic() - begun:.2f} s")
    try:
        motions(arm, rounds)
        faults(arm, stand_in, rounds)
    finally:
        arm.close()
        stand_in.stop()


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3, sys.argv[2] if len(sys.argv) > 2 else "ur")
