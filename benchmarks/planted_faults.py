"""Faults planted in copies of the example drivers: which clause of the contract finds each, and its message.

python benchmarks/planted_faults.py          every clause on every fault, some five minutes
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from stretch_bt.testing import device_contract

__all__ = ["FAULTS", "Fault", "fails", "planted"]

EXAMPLES = Path(__file__).parents[1] / "examples"
_GRIPPER = EXAMPLES / "modbus_gripper" / "stretch_bt_modbus_gripper"
_CAMERA = EXAMPLES / "ros_bag_camera" / "stretch_bt_ros_bag"


@dataclass(frozen=True)
class Fault:
    """A change of one text of a driver, the clause that is to find it, and words of its failure."""

    name: str
    package: Path
    old: str
    new: str
    clause: str
    words: str
    file: str = "driver.py"


_READS = "        return sample.reading(sample.value.opening)\n"
FAULTS = [
    Fault(
        "a reading 0.8 s old with the time of now",
        _GRIPPER,
        _READS,
        """\
        past = self.__dict__.setdefault("_past", [])
        past.append((self.now(), sample.value.opening))
        return sample.reading(([past[0][1]] + [v for t, v in past if t <= self.now() - 0.8])[-1])
""",
        "test_readings_follow_the_motion",
        r"at most 0\.\d+ s allowed: .*old",
    ),
    Fault(
        "a jump of 5 mm at opening",
        _GRIPPER,
        "    def halt(self",
        "    def open(self) -> None:\n        super().open()\n"
        "        self.do(lambda wire: wire.go(wire.read().opening + 0.005, 0.05))\n\n    def halt(self",
        "test_opening_moves_nothing",
        "opening moves the device",
    ),
    Fault(
        "it connects when constructed",
        _GRIPPER,
        "    def claimed(self)",
        "    def __init__(self, *given: Any) -> None:\n        super().__init__(*given)\n"
        "        TwoJawWire(self.options.host, self.options.port, 0.3).connect()\n\n    def claimed(self)",
        "test_constructing_touches_nothing",
        r"connect in open\(\)",
    ),
    Fault(
        "its numbers stand still",
        _GRIPPER,
        _READS,
        "        return Reading(sample.value.opening, sample.time, sample.time, 0)\n",
        "test_numbers_grow_with_new_readings",
        "only 1 new numbers",
    ),
    Fault(
        "openings in millimetres",
        _GRIPPER,
        _READS,
        "        return sample.reading(1e3 * sample.value.opening)\n",
        "test_values_are_in_si_units",
        "openings are in metres",
    ),
    Fault(
        "readings stamped when read",
        _GRIPPER,
        _READS,
        "        return Reading(sample.value.opening, sample.time, self.now(), sample.number)\n",
        "test_numbers_grow_with_new_readings",
        "stamped when read, not when taken",
    ),
    Fault(
        "a command that waits for its end",
        _GRIPPER,
        "        return poll\n",
        "        while poll() is MotionState.MOVING:\n            pass\n        return poll\n",
        "test_commands_return_at_once",
        "a command took",
    ),
    Fault(
        "the speed is not sent",
        _GRIPPER,
        "max(round(speed / r.SPEED_COUNT), 1)",
        "5000",
        "test_motions_arrive_in_their_time",
        "the speed is not sent",
    ),
    Fault(
        "stop does nothing",
        _GRIPPER,
        "        wire.hold()\n",
        "        pass\n",
        "test_stop_ends_a_motion",
        r"after stop\(\) the device went on to its target",
    ),
    Fault(
        "done as soon as commanded",
        _GRIPPER,
        "return MotionState.MOVING if told is None else",
        "return MotionState.DONE if told is None else",
        "test_commands_return_at_once",
        "as soon as it was commanded",
    ),
    Fault(
        "a loss is hidden by the last reading",
        _GRIPPER,
        "        sample = self.latest()\n" + _READS,
        """\
        try:
            self._last = self.latest()
        except DeviceFault:
            pass
        return self._last.reading(self._last.value.opening)
""",
        "test_a_loss_is_a_fault_that_stays",
        "still gives the same reading",
    ),
    Fault(
        "its thread goes on after close",
        _GRIPPER,
        "    def halt(self",
        "    def close(self) -> None:\n        self._thread = None\n\n    def halt(self",
        "test_open_and_close_as_often_as_wanted",
        "leaves the thread",
    ),
    Fault(
        "a command during a motion is ignored",
        _GRIPPER,
        "lambda wire: wire.go(opening, speed))",
        "lambda wire: wire.read().state == r.MOVING or wire.go(opening, speed))",
        "test_a_new_command_replaces_the_motion",
        "was not followed",
    ),
    Fault(
        "frames stamped when read",
        _CAMERA,
        "        return self._latest\n",
        "        t = self._latest\n        return Reading(t.value, t.device_time, self.now(), t.sequence)\n",
        "test_numbers_grow_with_new_readings",
        "stamped when read, not when taken",
    ),
    Fault(
        "frames that wait in a queue for 0.8 s",
        _CAMERA,
        "self._start + taken - self._zero, number)",
        "self._start + taken - self._zero + min(0.2 * number, 0.8), number)",
        "test_readings_are_as_old_as_they_say",
        r"are 0\.\d+ s old by the device's own clock",
    ),
    Fault(
        "one memory for all frames",
        _CAMERA,
        "        distance = self",
        "        memory = self.__dict__.setdefault('_memory', raw)\n        memory[:] = raw\n        raw = memory\n        distance = self",
        "test_frames_stay_as_they_were_given",
        "changed after it was given",
    ),
    Fault(
        "millimetres taken for metres",
        _CAMERA,
        '"16UC1": (np.uint16, 1e-3)',
        '"16UC1": (np.uint16, 1.0)',
        "test_values_are_in_si_units",
        "the median depth",
        "images.py",
    ),
]


@contextmanager
def planted(fault: Fault | None, package: Path, folder: Path) -> Iterator[type[Any]]:
    """Write a copy of a driver with a fault beside a cell file that imports it, and give the contract on that."""
    name = f"planted_{time.monotonic_ns()}"
    home = folder / name
    shutil.copytree(package, home, ignore=shutil.ignore_patterns("__pycache__"))
    for path in home.glob("*.py"):
        text = path.read_text("utf-8").replace(package.name, name)
        if fault is not None and path.name == fault.file:
            assert fault.old in text, f"{fault.name}: the driver has another text now"
            text = text.replace(fault.old, fault.new)
            text = text.replace("import GripperDriver,", "import DeviceFault, GripperDriver,")
        path.write_text(text, "utf-8")
    sys.path.insert(0, str(folder))
    try:
        yield _gripper(name, folder) if package == _GRIPPER else _camera(name, folder)
    finally:
        sys.path.remove(str(folder))


def _gripper(name: str, folder: Path) -> type[Any]:
    def cell(simulator: Any) -> Path:
        path = folder / f"{name}.yaml"
        device = f"{{type: Gripper, use: two_jaw_gripper, host: 127.0.0.1, port: {simulator.port}}}"
        path.write_text(f"format: stretch-cell/1\nimports: {{own: {name}}}\ndevices: {{gripper: {device}}}\n")
        return path

    return device_contract(
        cell,
        "gripper",
        kind="Gripper",
        start=lambda: import_module(f"{name}.simulator").Simulator(),
        moves=(0.060, 0.080),
        tolerance=0.0002,
        latency=0.2,
        cut=lambda simulator: simulator.stop(),
    )


def _camera(name: str, folder: Path) -> type[Any]:
    import numpy as np

    sys.path.insert(0, str(EXAMPLES / "ros_bag_camera" / "tests"))
    try:
        bags = import_module("bags")
    finally:
        del sys.path[0]
    noise = np.random.default_rng(0)
    bags.write_bag(folder / f"{name}_bag", (noise.integers(190, 210, (48, 64)).astype(np.uint16) for _ in range(90)))
    path = folder / f"{name}.yaml"
    device = f"{{type: DepthCamera, use: bag_camera, bag: {name}_bag}}"
    path.write_text(f"format: stretch-cell/1\nimports: {{own: {name}}}\ndevices: {{camera: {device}}}\n")
    return device_contract(path, "camera", tolerance=0.001, latency=0.15)


def fails(contract: type[Any], clause: str) -> str | None:
    """Return the message of a clause's failure, or None where it finds nothing."""
    case = contract()
    with contract.contract.trial() as case.trial:
        try:
            getattr(case, clause)()
        except pytest.fail.Exception as failure:
            return str(failure)
        except pytest.skip.Exception:
            return None
    return None


def main() -> None:
    """Print which clauses find each fault, and what the expected one says."""
    found = 0
    for fault in FAULTS:
        with tempfile.TemporaryDirectory() as folder, planted(fault, fault.package, Path(folder)) as contract:
            clauses = [name for name in dir(contract) if name.startswith("test_")]
            said = {name: text for name in clauses if (text := fails(contract, name)) is not None}
        found += fault.clause in said
        print(f"{'found' if fault.clause in said else 'MISSED'}  {fault.name}")
        for name, text in said.items():
            print(f"       {name}: {text}")
    print(f"{found} of {len(FAULTS)} found by the clause that is meant for them")


if __name__ == "__main__":
    main()
