"""Cell files of one device each: on a stand-in, or of a small recording."""

import itertools
import os
from pathlib import Path

import numpy as np

RECORDED = """\
format: stretch-cell/1
devices:
  camera: {type: DepthCamera, use: replay, file: press.npz, depth: z, time: t, unit: 0.1 mm, intrinsics: K, roi: roi}
  force_sensor: {type: ForceSensor, use: replay, file: press.npz}
  arm: {type: Arm, use: replay, file: press.npz}
"""

#: kinds of cell whose device is reached over a wire: its name in the file, its stand-in, the wire
LIVE = {
    "robotiq-rtu": ("robotiq", "robotiq", "rtu"),
    "robotiq-tcp": ("robotiq", "robotiq", "tcp"),
    "robotiq-serial": ("robotiq", "robotiq", "serial"),
    "urcap": ("robotiq_urcap", "urcap", "urcap"),
    "ati": ("ati", "ati", "rdt"),
    "ur": ("ur", "ur", "rtde"),
    "realsense": ("realsense", "realsense", "depth"),
}
#: a machine that is busy is no fault, where a test is not about deadlines
PATIENT = {"watchdog": "1 Hz", "lost_after": "2 s", "heartbeat": "5 s"}
#: stand-ins whose clients have their ports built in, so that each needs an address of its own
OWN_ADDRESS = {"ur", "ur5e"}
HOSTS = (f"127.{2 + os.getpid() % 250}.{k // 250}.{1 + k % 250}" for k in itertools.count())
_GRIPPER = """\
format: stretch-cell/1
limits: {gripper_speed: 150 mm/s}
devices:
  gripper:
    type: Gripper
    use: USE
    model: 2f140
"""
CALIBRATION = "{points: [{count: 3, opening: 140 mm}, {count: 230, opening: 0 mm}], source: the stand-in's own}"
LIVE_CELLS = {
    "robotiq": _GRIPPER.replace("USE", "robotiq"),
    "robotiq_urcap": _GRIPPER.replace("USE", "robotiq_urcap"),
    "ati": """\
format: stretch-cell/1
devices:
  force_sensor:
    type: ForceSensor
    use: ati
    calibration: {counts_per_newton: 1000000, counts_per_newton_metre: 1000000, source: the stand-in's own}
""",
    "ur": """\
format: stretch-cell/1
limits: {unwatched: UNWATCHED}
devices:
  arm:
    type: Arm
    use: ur
    base: {x: -500 mm}
    hand: {z: 300 mm, rx: 180 deg}
    source: the stand-in's own
""",
    "realsense": """\
format: stretch-cell/1
devices:
  camera:
    type: DepthCamera
    use: realsense
""",
}


def write_live_cell(folder: Path, use: str, wire: str, place: str, unwatched: str = "20 s", **options: str) -> Path:
    """Write a cell file of one device on a stand-in."""
    host, _, port = place.partition(":")
    chosen = {"serial": place} if wire == "serial" else {"host": host, "port": port}
    if wire == "tcp":
        chosen["framing"] = "tcp"
    if use == "ur":
        chosen = {"host": host, "model": "ur5", **PATIENT}
    elif use == "realsense":
        chosen = {**chosen, "lost_after": "5 s"}
    elif use != "ati":
        chosen = {"timeout": "500 ms", "calibration": CALIBRATION, **chosen}
    lines = [f"    {key}: {value}" for key, value in {**chosen, **options}.items()]
    path = folder / f"{use}_{wire}.yaml"
    path.write_text(LIVE_CELLS[use].replace("UNWATCHED", unwatched) + "\n".join(lines) + "\n")
    return path


def recording() -> dict[str, np.ndarray]:
    """Return the arrays of a small recording: five frames at 10 Hz, cut out of a larger image."""
    random = np.random.default_rng(0)
    return {
        "z": random.integers(500, 900, (5, 6, 8), dtype=np.uint16),
        "t": 100.0 + np.arange(5) / 10,
        "K": np.array([434.0, 433.0, 4.0, 3.0]),
        "roi": np.array([1, 7, 2, 10]),
        "wrench": np.outer(np.arange(5.0), np.ones(6)),
        "pose": np.outer(0.01 * np.arange(5.0), np.ones(6)),
    }


def write_recording(folder: Path, **changes: np.ndarray) -> Path:
    """Write the recording and a cell file that plays it."""
    np.savez(folder / "press.npz", **{**recording(), **changes})
    (folder / "cell.yaml").write_text(RECORDED)
    return folder / "cell.yaml"
