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
  arm: {type: Arm, use: ur, host: HOST, model: ur5, base: {x: -500 mm}, hand: {z: 300 mm, rx: 180 deg}, source: a test}
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
#: faults that are seen only while their device moves
MOVING = {("ur", fault) for fault in ("deaf", "stall", "slider", "no_solution")} | {("robotiq", "stall")}
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
    host = next(own_hosts)
    (tmp_path / "wired.yaml").write_text(CELL.replace("HOST", host))
    (tmp_path / "tree.yaml").write_text(TREE)
    with serving(["ur", "robotiq", "ati"], Stage(), host=host, activated=True) as servers:
        behind, injected = servers.stand_ins, []
        chaos = threading.Thread(target=harm, args=(behind, PHASES[phase], device, fault, injected))
        chaos.start()
        result = run(tmp_path / "tree.yaml", cell=tmp_path / "wired.yaml", out=tmp_path / "record")
        ended = time.monotonic()
        chaos.join()
        assert (result.status, result.reason != "") == ("FAULT", True)
        assert injected, "it ended before the fault"
        assert {path.name for path in (tmp_path / "record").iterdir()} == RECORD
        assert children() == []
        wait(lambda: not behind["ur"].state()["moving"])
        before = behind["ur"].state(), behind["robotiq"].state()["opening"]
        time.sleep(0.2)
        assert behind["ur"].state()["moved"] == before[0]["moved"]
        if not (
            device == "robotiq"
            and fault in ("drop", "freeze", "slow", "corrupt", "truncate", "garbage", "crc", "refuse")
        ):
            assert behind["robotiq"].state()["opening"] == before[1]
        print(f"{phase:8s}{device:8s}{fault:16s}{ended - injected[0]:7.3f} s  {result.reason[:80]}")  # noqa: T201


def harm(behind, reached, device, fault, injected):
    """Wait for a phase, and inject a fault."""
    wait(lambda: reached(behind))
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
