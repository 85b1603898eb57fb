import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from live_cells import HOSTS, LIVE, OWN_ADDRESS, recording, write_live_cell, write_recording

from stretch_bt.errors import DeviceFault
from stretch_bt.hardware.ati.force_sensor import AtiForceSensor
from stretch_bt.hardware.cell import Cell, open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.driver import Driver
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.stand_in import Ur5StandIn
from stretch_bt.hardware.realsense.camera import RealsenseCamera
from stretch_bt.hardware.realsense.library import library
from stretch_bt.hardware.robotiq.driver import RobotiqDriver
from stretch_bt.hardware.ur.arm import UrArm
from stretch_bt.simulation.scene import load_scene


class Clock:
    """A clock that stands until it is moved; after that it waits until all listeners have noticed.

    One that `runs` goes by itself.
    """

    def __init__(self, time: float = 0.0) -> None:
        self._time = time
        self.runs = False
        self.listeners: list[Callable[[], None]] = []

    def __call__(self) -> float:
        return time.monotonic() if self.runs else self._time

    @property
    def time(self) -> float:
        return self()

    @time.setter
    def time(self, due: float) -> None:
        self._time = due
        for listen in self.listeners:
            listen()


class Notes:
    """A journal that keeps every line it is given."""

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

    def unanswered(self, device, none):
        self.lines.append(("unanswered", device, type(none).__name__))


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def notes() -> Notes:
    return Notes()


@pytest.fixture
def stand_in(clock: Clock):
    """Start a stand-in by its name, on a free port of loopback, its fingers moving by the test's clock."""
    started: list[StandIn] = []

    def start(name: str, **options) -> tuple[StandIn, dict[str, str]]:
        cls = stand_in_class(name)
        own = name in OWN_ADDRESS
        host, ports = (next(HOSTS), {}) if own else ("127.0.0.1", dict.fromkeys(cls.PORTS, 0))
        made = cls(host, StandInWorld(now=clock, **options), ports)
        made.activated()
        started.append(made)
        return made, made.start()

    yield start
    for one in started:
        one.stop()


@pytest.fixture
def make_cell(tmp_path: Path, clock: Clock, notes: Notes, stand_in):
    """Open a cell by kind; all are closed at the end. A cell on a stand-in has that as `stand_in`."""
    opened: list[Cell] = []

    def make(
        kind: str = "simulated", *, scene: str = "calibration_sphere", seed: int = 0, only=None, **options
    ) -> Cell:
        if kind == "realsense":
            librealsense()
        if kind in LIVE:
            use, server, wire = LIVE[kind]
            behind, places = stand_in(server)
            path = write_live_cell(tmp_path, use, wire, places[wire], **options)
        else:
            path = write_recording(tmp_path) if kind == "replay" else kind
        chosen = load_scene(scene) if kind == "simulated" else None
        cell = open_cell(load_cell(path), now=clock, seed=seed, scene=chosen, journal=notes, only=only)
        opened.append(cell)
        if kind in LIVE:
            cell.stand_in = behind
            clock.listeners += [partial(notice, device.driver, clock) for device in cell.devices.values()]
            if kind == "ur":
                clock.listeners.insert(0, partial(wait_as_long, behind, clock, [clock.time]))
        return cell

    yield make
    clock.listeners.clear()
    for cell in opened:
        cell.close()


@pytest.fixture(name="librealsense", scope="session")
def _librealsense():
    return librealsense()


def librealsense():
    """Return the module, or skip a test on a machine for which there is none."""
    try:
        return library()
    except ImportError as error:
        pytest.skip(str(error))


def notice(driver: Driver, clock: Clock) -> None:
    """Wait until a driver has a reading of this moment, or says why it has none."""
    end = time.monotonic() + 10
    with suppress(DeviceFault):
        if isinstance(driver, RobotiqDriver):
            driver.status()
        before = driver.frame().sequence if isinstance(driver, RealsenseCamera) else 0
        while isinstance(driver, RealsenseCamera) and driver.frame().sequence < before + 2:
            assert time.monotonic() < end, "no new frame comes"
            time.sleep(0.002)
        while isinstance(driver, AtiForceSensor | UrArm) and driver.wrench().host_time < clock.time:
            assert time.monotonic() < end, "no reading of this moment comes"
            time.sleep(0.002)


def wait_as_long(arm: Ur5StandIn, clock: Clock, before: list[float]) -> None:
    """Wait as long as the clock was moved, because the arm goes by its own; an arm that stands is not waited for."""
    end, before[0] = time.monotonic() + clock.time - before[0], clock.time
    stood = time.monotonic()
    while time.monotonic() < end and time.monotonic() - stood < 0.15:
        if not arm.arm.steady:
            stood = time.monotonic()
        time.sleep(0.002)


@pytest.fixture(scope="session")
def own_hosts():
    """Loopback addresses that nobody else has."""
    return HOSTS


@pytest.fixture(scope="session")
def write_cell():
    """Write a cell file of one device at a place into a folder, and return its path."""
    return write_live_cell


@pytest.fixture
def live_cell(tmp_path: Path):
    """Write a cell file of one device at a place, and return its path."""
    return partial(write_live_cell, tmp_path)


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
