"""Runs over the wires of arm, gripper and force sensor, each ended by a fault of one of them while something moves."""

import os
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from stretch_bt import run
from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.serve import serving
from stretch_bt.hardware.emulators.stage import Stage

CELL = """\
format: stretch-cell/1
devices:
  arm:
    type: Arm
    use: ur
    host: HOST
    model: ur5
    base: {x: -500 mm}
    hand: {z: 300 mm, rx: 180 deg}
    source: a test
    watchdog: 2.5 Hz
    lost_after: 400 ms
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
"""
TREE = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper, force_sensor: ForceSensor}
trees:
  main:
    guard: {that: "arm.force < 15 N and force_sensor.force < 15 N and gripper.opening < 1 m", name: watched}
    sequence:
      - set_stretch: {stretch: 30 mm, speed: 20 mm/s}
      - retract: {clearance: 30 mm, speed: 20 mm/s}
      - move_over: {x: 30 mm, y: 0 mm, speed: 20 mm/s}
"""
RECORD = {"run.json", "events.jsonl", "record.mcap", "result.json", "report.html"}
LIMIT = 30.0
PARAMETERS = {
    ("ur", "slow"): {"rate": 1.0},
    ("ur", "late"): {"delay": 1.0},
    ("ur", "garbage"): {"bytes": 300},
    ("ur", "load"): {"fz": 30.0},
    ("ur", "slider"): {"fraction": 0.05},
    ("ati", "load"): {"fz": 20.0},
    ("robotiq", "slow"): {"delay": 0.6},
    ("robotiq", "garbage"): {"bytes": 400},
}
#: what ends no run, or not the one of a device that is not told to move then
HARMLESS = {
    *(("ur", fault) for fault in ("registers", "local", "loss", "wall")),
    *(("robotiq", fault) for fault in ("object", "unit", "late", "deaf")),
    *(("ati", fault) for fault in ("loss", "reorder", "repeat", "short", "slow", "drift")),
}
#: what ends a run otherwise than as a fault: the tree's own guard
STATED = {("ati", "load"): {"FAILURE"}, ("ur", "load"): {"FAULT", "FAILURE"}}
#: how often a run may be begun again that this machine was too busy for, so that it ended before its fault
AGAIN = 3
#: faults that are seen only while their device moves
MOVING = {("ur", fault) for fault in ("deaf", "stall", "slider", "no_solution")} | {("robotiq", "stall")}
#: a gripper that cannot be reached goes on to where it was last sent
UNTOLD = {("robotiq", fault) for fault in ("drop", "freeze", "slow", "corrupt", "truncate", "garbage", "crc", "refuse")}
PHASES: dict[str, Callable] = {
    "stretch": lambda s: s["robotiq"].state()["opening"] > 0.060,
    "up": lambda s: s["ur"].state()["height"] > 0.203,
    "across": lambda s: s["ur"].state()["x"] > 0.003,
}


def cases():
    for phase in PHASES:
        for device in ("ur", "robotiq", "ati"):
            for fault in stand_in_class(device).FAULTS:
                still = (device, fault) in MOVING and (device == "ur") is (phase == "stretch")
                if (device, fault) not in HARMLESS and not still:
                    yield phase, device, fault


FEW = {
    ("stretch", "robotiq", "code"),
    ("up", "ur", "protective_stop"),
    ("across", "ati", "silence"),
    ("up", "ur", "freeze"),
}


@pytest.mark.parametrize(
    ("phase", "device", "fault"), [pytest.param(*c, marks=() if c in FEW else pytest.mark.slow) for c in cases()]
)
def test_a_fault_ends_the_run_and_nothing_moves_after_it(own_hosts, tmp_path, phase, device, fault):
    (tmp_path / "tree.yaml").write_text(TREE)
    for k in range(AGAIN):
        host, record = next(own_hosts), tmp_path / f"record{k}"
        (tmp_path / "wired.yaml").write_text(CELL.replace("HOST", host))
        with serving(["ur", "robotiq", "ati"], Stage(), host=host, activated=True) as servers:
            injected = ended_by(servers.stand_ins, PHASES[phase], device, fault, (tmp_path, record))
        if injected is not None:
            print(f"{phase:8s}{device:8s}{fault:16s}{injected[0]:7.3f} s  {injected[1]}")  # noqa: T201
            return
    raise AssertionError("it ended before the fault")


def ended_by(behind, reached, device, fault, folders):
    """Run until a fault, and return how long it took to its end and why; None where the run ended before."""
    folder, record = folders
    injected, over = [], threading.Event()
    chaos = threading.Thread(target=harm, args=(behind, reached, device, fault, injected, over))
    chaos.start()
    try:
        result = run(folder / "tree.yaml", cell=folder / "wired.yaml", out=record)
    finally:
        ended = time.monotonic()
        over.set()
        chaos.join()
    assert children() == []
    assert {path.name for path in record.iterdir()} == RECORD
    if not injected:
        return None
    assert result.status in STATED.get((device, fault), {"FAULT"})
    assert result.reason
    wait(lambda: not behind["ur"].state()["moving"])
    before = behind["ur"].state(), behind["robotiq"].state()["opening"]
    time.sleep(0.2)
    assert behind["ur"].state()["moved"] == before[0]["moved"]
    if (device, fault) not in UNTOLD:
        assert behind["robotiq"].state()["opening"] == before[1]
    return ended - injected[0], result.reason[:80]


def harm(behind, reached, device, fault, injected, over):
    """Wait for a phase, and inject a fault."""
    while not (reached(behind) or over.is_set()):
        time.sleep(0.005)
    if not over.is_set():
        behind[device].inject(fault, PARAMETERS.get((device, fault)))
        injected.append(time.monotonic())


def wait(ask):
    end = time.monotonic() + LIMIT
    while not ask():
        assert time.monotonic() < end, "it does not come"
        time.sleep(0.005)


def children():
    """Return the processes of arms that this one began and that are left."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split() if entry.name.isdigit() else []
            command = (entry / "cmdline").read_bytes() if fields and int(fields[1]) == os.getpid() else b""
        except OSError:  # it ended meanwhile
            continue
        if b"stretch_bt.hardware.ur.process" in command:
            found.append(entry.name)
    return found
