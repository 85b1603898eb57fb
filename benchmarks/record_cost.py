"""Cost of the record of a run: time and bytes for a frame, a reading, an event and a whole tick.

Run with `python benchmarks/record_cost.py`. Frames are 215 by 240 uint16 with noise of 3 counts.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.record.folder import MCAP

FRAMES, CALLS, PERIOD = 100, 5000, 0.05


def frame(number: int) -> Reading[DepthFrame]:
    raw = (1600 + np.random.default_rng(number).normal(0, 3, (215, 240))).astype(np.uint16)
    intrinsics = Intrinsics(475.0, 475.0, 120.0, 107.0, 240, 215)
    now = number * PERIOD
    return Reading(DepthFrame(raw, 1.25e-4, intrinsics, now, number, 0.2), now, now, number)


def frames(folder: Path) -> None:
    readings = [frame(number) for number in range(FRAMES)]
    record = RunRecord(folder)
    record.start({}, {})
    start = time.perf_counter()
    for reading in readings:
        record.begin_tick(reading.sequence, reading.host_time)
        record.reading("camera", "frame", reading)
    record.close({})
    written = time.perf_counter() - start
    reader = RecordReader(folder)
    start = time.perf_counter()
    same = sum(np.array_equal(reader.readings(r.sequence)[0][2].value.raw, r.value.raw) for r in readings)
    read = time.perf_counter() - start
    size = (folder / MCAP).stat().st_size / FRAMES
    print(f"frame: write {written / FRAMES * 1e3:.2f} ms, read {read / FRAMES * 1e3:.2f} ms, {size:.0f} bytes "
          f"({readings[0].value.raw.nbytes} raw), {same} of {FRAMES} identical")  # fmt: skip


def calls(folder: Path) -> None:
    record = RunRecord(folder)
    record.start({}, {})

    def tick(i: int) -> None:
        record.begin_tick(i, i * PERIOD)
        number(i)
        record.reading("arm", "pose", Reading(Pose((0.1, 0.2, i * 1e-6)), i * PERIOD, i * PERIOD, i))
        record.reading("arm", "wrench", Reading(Wrench((0.1, 0.2, i * 1e-6)), i * PERIOD, i * PERIOD, i))
        record.motion("arm", "main/press", MotionState.MOVING)

    def number(i: int) -> None:
        record.reading("gripper", "opening", Reading(0.055 + i * 1e-6, i * PERIOD, i * PERIOD, i))

    def status(i: int) -> None:
        record.status("main/sequence/press", ("RUNNING", "SUCCESS")[i % 2], "to 10 mm")

    def write(i: int) -> None:
        record.write("depth", i * 1e-5, 1e-6, "main/sequence/press")

    cases: dict[str, Callable[[int], None]] = {
        "number reading": number,
        "status event": status,
        "key write": write,
        "tick of 3 readings and a poll, on the disk": tick,
    }
    for name, call in cases.items():
        before, start = (folder / MCAP).stat().st_size, time.perf_counter()
        for i in range(CALLS):
            call(i)
        spent = time.perf_counter() - start
        record.begin_tick(CALLS, CALLS * PERIOD)
        size = ((folder / MCAP).stat().st_size - before) / CALLS
        print(f"{name}: {spent / CALLS * 1e6:.1f} us, {size:.0f} bytes of record.mcap")
    record.close({})


if __name__ == "__main__":
    with TemporaryDirectory() as place:
        frames(Path(place) / "frames")
        calls(Path(place) / "calls")
