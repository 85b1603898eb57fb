"""A record as a run makes one, and what two equal values have in common."""

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stretch_bt.errors import DeviceFault, StaleReading
from stretch_bt.frames import DepthFrame, Intrinsics, Pose
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.runtime.record import Handed, RunRecord

INTRINSICS = Intrinsics(475.1, 475.3, 11.7, 9.2, 24, 20, (0.1, -0.2, 1e-3, 0.0, 0.3))


class Cloud:
    points = np.arange(30.0).reshape(10, 3)


def frame(number: int) -> Reading[DepthFrame]:
    raw = np.random.default_rng(number).integers(900, 1000, (20, 24)).astype(np.uint16)
    return Reading(DepthFrame(raw, 125e-6, INTRINSICS, number / 30, number, 0.2), number / 30, number / 20, number)


def run(record: RunRecord, ticks: int = 6) -> None:
    """Drive a record as a runner does."""
    record.start({"tree": {"name": "press"}, "seed": 0, "keys": {"depth": "Length"}}, {"host": "lab", "wall": 1.5})
    for tick in range(ticks):
        record.begin_tick(tick, tick / 20)
        record.reading("arm", "pose", Reading(Pose((0.0, 0.1, 0.3 - tick / 1000)), tick / 20, tick / 20, tick))
        record.reading("camera", "frame", frame(tick // 2))
        record.motion("arm", "main/press", MotionState.MOVING if tick < ticks - 1 else MotionState.DONE)
        record.status("main/press", "RUNNING" if tick else "SUCCESS", "")
        record.write("depth", tick / 1000, 1e-5, "main/press")
    record.command("arm", "move", {"target": Pose(), "speed": 0.01}, "main/press")
    record.write("contact", Cloud(), None, "main/feel")
    record.write("label", None, None, "main/feel")
    record.fault("camera", StaleReading("camera", "the frame is 0.3 s old"))
    record.note("overrun", seconds=np.float64("inf"))


def closed(folder: Path, ticks: int = 6) -> Path:
    record = RunRecord(folder)
    run(record, ticks)
    record.close({"status": "SUCCESS", "outputs": {"depth": {"value": 0.005, "unit": "m", "sd": None}}})
    return folder


def shown(value: Any) -> Any:
    """What two equal values have in common, NaN and arrays included."""
    if isinstance(value, Handed):
        return value.kind, value.device, value.name, shown(value.value)
    if isinstance(value, Reading):
        return shown(value.value), value.device_time, value.host_time, value.sequence
    if isinstance(value, DepthFrame):
        rest = [getattr(value, name) for name in DepthFrame.__slots__ if name != "raw"]
        return value.raw.dtype, value.raw.shape, value.raw.tobytes(), rest
    if isinstance(value, DeviceFault):
        return type(value), value.device, value.reason
    return "nan" if isinstance(value, float) and math.isnan(value) else (type(value), value)


@pytest.fixture(scope="session")
def sample() -> SimpleNamespace:
    return SimpleNamespace(frame=frame, run=run, closed=closed, shown=shown, points=Cloud.points)
