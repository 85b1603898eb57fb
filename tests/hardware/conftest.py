from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.hardware.cell import Cell, open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.simulation.scene import load_scene

RECORDED = """\
format: stretch-cell/1
devices:
  camera: {type: DepthCamera, use: replay, file: press.npz, depth: z, time: t, unit: 0.1 mm, intrinsics: K, roi: roi}
  force_sensor: {type: ForceSensor, use: replay, file: press.npz}
"""


class Clock:
    """A clock that stands until it is moved."""

    def __init__(self, time: float = 0.0) -> None:
        self.time = time

    def __call__(self) -> float:
        return self.time


class Notes:
    """A journal that keeps what it is told."""

    def __init__(self) -> None:
        self.lines: list[tuple] = []

    def reading(self, device, name, reading):
        self.lines.append(("reading", device, name))

    def command(self, device, name, arguments, owner):
        self.lines.append(("command", device, name, owner))

    def motion(self, device, owner, state):
        self.lines.append(("motion", device, owner, state))

    def fault(self, device, fault):
        self.lines.append(("fault", device, type(fault).__name__))


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def notes() -> Notes:
    return Notes()


@pytest.fixture
def make_cell(tmp_path: Path, clock: Clock, notes: Notes):
    """Open a cell by kind; all are closed at the end."""
    opened: list[Cell] = []

    def make(kind: str = "simulated", *, scene: str = "calibration_sphere", seed: int = 0, only=None) -> Cell:
        spec = load_cell(kind if kind != "replay" else write_recording(tmp_path))
        chosen = None if kind == "replay" else load_scene(scene)
        cell = open_cell(spec, now=clock, seed=seed, scene=chosen, journal=notes, only=only)
        opened.append(cell)
        return cell

    yield make
    for cell in opened:
        cell.close()


def recording() -> dict[str, np.ndarray]:
    """Return the arrays of a small recording: five frames at 10 Hz, cut out of a larger image."""
    random = np.random.default_rng(0)
    return {
        "z": random.integers(500, 900, (5, 6, 8), dtype=np.uint16),
        "t": 100.0 + np.arange(5) / 10,
        "K": np.array([434.0, 433.0, 4.0, 3.0]),
        "roi": np.array([1, 7, 2, 10]),
        "wrench": np.outer(np.arange(5.0), np.ones(6)),
    }


def write_recording(folder: Path, **changes: np.ndarray) -> Path:
    """Write the recording and a cell file that plays it."""
    np.savez(folder / "press.npz", **{**recording(), **changes})
    (folder / "cell.yaml").write_text(RECORDED)
    return folder / "cell.yaml"


@pytest.fixture
def advance(clock: Clock) -> Callable[..., None]:
    """Poll a motion at 50 Hz until it has ended."""

    def run(motion, *, at_most: float = 30.0):
        end = clock.time + at_most
        while (state := motion.poll()) == "moving":
            assert clock.time < end, "the motion does not end"
            clock.time += 0.02
        return state

    return run


@pytest.fixture
def record(tmp_path: Path):
    """Write the recording, some arrays changed, and return its cell file; `record.arrays` are the unchanged ones."""

    def write(**changes: np.ndarray) -> Path:
        return write_recording(tmp_path, **changes)

    write.arrays = recording()
    return write
