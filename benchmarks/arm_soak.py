"""An arm that goes to and fro for long over its wires, on loopback: leaks, deadlines that drift, watchdogs that fire.

Run with `python benchmarks/arm_soak.py [minutes] [ur|ur5e]`. The stand-in is in a process of its own. Every minute a line: motions,
readings, the longest that two were apart, how much longer a motion took than the first ones, and memory, files and threads of this
process, of the driver's and of the stand-in's. A watchdog that stops the program, or any other fault, is printed and counted.
"""

from __future__ import annotations

import math
import os
import statistics
import sys
import time
from pathlib import Path

from stretch_bt.errors import DeviceFault
from stretch_bt.frames import Pose
from stretch_bt.hardware.driver import CellContext
from stretch_bt.hardware.emulators.serve import serving_elsewhere
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.ur.arm import UrArm

HOST = "127.0.0.61"
HAND = {"z": "300 mm", "rx": "180 deg"}
SQUARE = [(0.02, 0.0, 0.18), (0.02, 0.02, 0.19), (0.0, 0.02, 0.2), (0.0, 0.0, 0.2)]


def open_arm(model: str, host: str = HOST, **options: object) -> UrArm:
    """Return a driver that is open on a stand-in."""
    given = {
        "model": "ur5" if model == "ur" else model,
        "base": {"x": "-500 mm"},
        "hand": HAND,
        "source": "the stand-in's own",
    }
    chosen = UrArm.Options.model_validate({"type": "Arm", "use": "ur", "host": host, **given, **options})
    arm = UrArm("arm", chosen, CellContext(time.monotonic, 0, Path(), Hand(), Limits()))
    arm.open()
    return arm


def weight(pid: int) -> tuple[float, int, int]:
    """Return memory, MB, and counts of open files and threads of a process."""
    fields = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines() if ":" in line)
    return (
        int(fields["VmRSS"].split()[0]) / 1024,
        sum(1 for _ in Path(f"/proc/{pid}/fd").iterdir()),
        int(fields["Threads"]),
    )


class Minute:
    """What happened in a minute."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.readings, self.apart = 0, 0.0


def ride(arm: UrArm, minute: Minute) -> None:
    """Go round once, and count what is read on the way."""
    begun = seen = time.monotonic()
    number = -1
    poll = arm.follow([Pose(corner) for corner in SQUARE], 0.05)
    while poll() is MotionState.MOVING:
        reading = arm.pose()
        if reading.sequence != number:
            minute.readings += reading.sequence - number if number >= 0 else 1
            now = time.monotonic()
            minute.apart, seen, number = max(minute.apart, now - seen), now, reading.sequence
        time.sleep(0.004)
    minute.times.append(time.monotonic() - begun)


def soak(arm: UrArm, minutes: float, server: int) -> None:
    """Print a line a minute, and each fault, after which it goes on."""
    end, first, rides, faults = time.monotonic() + 60 * minutes, 0.0, 0, 0
    for k in range(1, math.ceil(minutes) + 1):
        minute, until = Minute(), min(time.monotonic() + 60, end)
        while time.monotonic() < until:
            try:
                ride(arm, minute)
            except DeviceFault as fault:
                faults += 1
                print(f"  fault: {fault}", flush=True)
                go_on(arm)
        rides += len(minute.times)
        middle = statistics.median(minute.times)
        first = first or middle
        sizes = [
            (name, weight(pid))
            for name, pid in (("here", os.getpid()), ("driver", arm.process or 0), ("stand-in", server))
        ]
        parts = [f"{name} {m:.1f} MB {f} files {t} threads" for name, (m, f, t) in sizes]
        print(
            f"{k:3d} min, {rides} rides, {faults} faults, median {middle:.3f} s ({1e3 * (middle - first):+.0f} ms), "
            f"{minute.readings} readings, at most {1e3 * minute.apart:.0f} ms apart; " + "; ".join(parts),
            flush=True,
        )


def go_on(arm: UrArm) -> None:
    """Open the arm anew as soon as that can be done."""
    for _ in range(100):
        arm.close()
        try:
            arm.open()
        except DeviceFault:
            time.sleep(0.1)
        else:
            return
    raise SystemExit("it does not come back")


def main(minutes: float, model: str) -> None:
    """Soak."""
    with serving_elsewhere([model], host=HOST) as servers:
        arm = open_arm(model)
        (process,) = servers.processes
        soak(arm, minutes, process.pid)
        print("events of the controller:", servers.stand_ins[model].state()["events"] or "none")
        arm.close()


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0, sys.argv[2] if len(sys.argv) > 2 else "ur")
