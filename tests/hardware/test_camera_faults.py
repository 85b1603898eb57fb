"""Every fault that the stand-in of a camera can show, and its process killed; runs that they end are in `test_wired_run.py`."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from waiting import LIMIT, eventually

from stretch_bt.errors import DeviceFault, DeviceLost, StaleReading
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.emulators.realsense import RealsenseStandIn
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.interfaces import DeviceState
from stretch_bt.hardware.realsense.inbox import Inbox
from stretch_bt.hardware.realsense.judge import FrameCounters
from stretch_bt.hardware.realsense.library import library
from stretch_bt.hardware.realsense.messages import CameraStatus, Lens, Taken

try:
    library()
except ImportError as error:
    pytest.skip(str(error), allow_module_level=True)

LOST = "600 ms"

# (fault, parameters, kind of the fault, what it says)
ENDS = [
    ("drop", {}, DeviceLost, "connection"),
    ("reset", {}, DeviceLost, "connection"),
    ("freeze", {}, DeviceLost, "nothing came"),
    ("slow", {"rate": 0.5}, DeviceLost, "nothing came"),
    ("late", {"delay": 2.0}, DeviceLost, "nothing came"),
    ("loss", {"part": 1.0}, DeviceLost, "nothing came"),
    ("repeat", {}, DeviceLost, "the same frame again and again"),
    ("clock", {}, DeviceLost, "the time of its frames stands"),
    ("stale", {}, DeviceLost, "its image stands"),
    ("torn", {}, DeviceLost, "its images are torn"),
    ("torn", {"part": 0.1}, DeviceLost, "its images are torn"),
    ("dark", {}, DeviceLost, "no pixel of its images has a value"),
    ("corrupt", {}, DeviceLost, "its data are broken"),
    ("truncate", {}, DeviceLost, "its data are broken|connection"),
    ("garbage", {}, DeviceLost, "connection"),
    ("restart", {}, DeviceFault, "the camera was restarted"),
    ("jump", {}, DeviceFault, "its clock jumped ahead by"),
]
#: faults that others stand for, which are seen and reported alike
ALIKE = {"reset", "slow", "late", "loss", "clock", "dark", "truncate", "garbage", "jump"}
#: faults whose lasting kind is in the default run
LASTING = {"repeat", "stale", "torn", "corrupt"}
# (fault, parameters, the counter that shows it)
HARMLESS = [
    ("loss", {"part": 0.4}, "lost"),
    ("reorder", {"part": 0.4}, "late"),
    ("repeat", {"times": 6}, "repeated"),
    ("clock", {"times": 6}, "stale"),
    ("stale", {"times": 6}, "stale"),
    ("torn", {"times": 6}, "torn"),
    ("dark", {"times": 6}, "empty"),
    ("corrupt", {"times": 6}, "broken"),
]
OTHERS = {"exchange"}


@pytest.fixture(scope="module")
def shared(tmp_path_factory, write_cell):
    """A cell on a stand-in, which the tests leave ready."""
    behind = RealsenseStandIn("127.0.0.1", StandInWorld(), {"depth": 0})
    path = write_cell(tmp_path_factory.mktemp("camera"), "realsense", "depth", behind.start()["depth"], lost_after=LOST)
    cell = open_cell(load_cell(path), now=time.monotonic)
    cell.stand_in = behind
    yield cell
    cell.close()
    behind.stop()


@pytest.fixture
def camera(shared):
    """The camera, ready, and its stand-in."""
    device = shared.devices["camera"]
    yield device, shared.stand_in
    shared.stand_in.clear()
    anew(device)


def fault_of(device, age=1e9):
    """Read until a reading raises a fault, and return that; all frames before it are new ones."""
    end, numbers = time.monotonic() + LIMIT, []
    while time.monotonic() < end:
        try:
            numbers.append(device.frame(age).device_time)
        except DeviceFault as fault:
            assert numbers == sorted(numbers)
            return fault
        time.sleep(0.005)
    raise AssertionError("no fault comes")


def anew(device):
    """Close the camera, and open it as a new run does."""
    device.close()
    device.open()
    assert device.state is DeviceState.READY
    return fresh(device)


def fresh(device):
    """Return a reading that came after this was asked."""
    before = device.frame(1e9).sequence
    return eventually(lambda: (reading := device.frame(1e9)).sequence > before + 1 and reading)


def test_every_fault_is_in_a_table():
    assert {row[0] for row in (*ENDS, *HARMLESS)} | OTHERS == set(RealsenseStandIn.FAULTS)


@pytest.mark.parametrize(
    ("fault", "parameters", "kind", "said"),
    [pytest.param(*row, marks=[pytest.mark.slow] if row[0] in ALIKE or row[1] else []) for row in ENDS],
)
def test_a_fault_stays_until_a_new_run(camera, fault, parameters, kind, said):
    device, stand_in = camera
    fresh(device)
    stand_in.inject(fault, parameters)
    found = fault_of(device)
    assert type(found) is kind
    with pytest.raises(kind, match=said):
        raise found
    assert device.state is DeviceState.FAULT
    assert "start a new run" in str(found)
    stand_in.clear()
    with suppress(DeviceFault):
        fresh(device)
    assert device.state is DeviceState.FAULT
    assert anew(device).value.raw.any()


@pytest.mark.parametrize(
    ("fault", "parameters", "counter"),
    [pytest.param(*row, marks=[pytest.mark.slow] if row[0] in LASTING else []) for row in HARMLESS],
)
def test_a_frame_that_is_bad_is_left_out_and_does_no_harm(camera, fault, parameters, counter):
    device, stand_in = camera
    before = getattr(device.driver.counters(), counter)
    stand_in.inject(fault, parameters)
    times = {}

    def seen():
        reading = device.frame(1e9)
        times[reading.sequence] = reading.value.time
        return getattr(device.driver.counters(), counter) > before + 3

    eventually(seen)
    assert list(times.values()) == sorted(set(times.values()))
    assert device.state is DeviceState.READY


def test_what_happens_between_two_looks_is_told_once():
    inbox = Inbox(latency=0.0, plane_distance=None, now=lambda: (0.0, 0.0))
    inbox.take(Lens(1e-3, 10.0, 10.0, 1.0, 1.0, 2, 2, (0.0,) * 5))
    for event in ("the camera was restarted", None, "its clock jumped"):
        inbox.take(CameraStatus(Taken(0.0, 0.0), 0.0, None, event, False, FrameCounters()))
    assert inbox.event() == "the camera was restarted"
    assert inbox.event() is None
    inbox.close()


def test_what_is_slow_is_quick_again_once_that_is_cleared(camera):
    device, stand_in = camera
    stand_in.inject("slow", {"rate": 0.01})
    fault_of(device)
    stand_in.clear()
    anew(device)


def test_frames_that_come_late_are_old(camera):
    """Their age counts from their exposure, not from when they came."""
    device, stand_in = camera
    assert time.monotonic() - fresh(device).host_time < 0.4
    stand_in.inject("late", {"delay": 0.5})
    eventually(lambda: time.monotonic() - device.frame(1e9).host_time > 0.5 and fresh(device))
    with pytest.raises(StaleReading, match="latest frame is 0"):
        device.frame(0.4)
    assert device.state is DeviceState.READY


def test_what_the_camera_tells_is_taken_from_it(camera):
    device, _ = camera
    lens, frame = device.intrinsics, device.frame(1e9).value
    assert (lens.fx, lens.cx, lens.width, lens.height) == (238.0, 160.0, 320, 240)
    assert frame.intrinsics == lens
    assert frame.unit == pytest.approx(0.000125, rel=1e-6)
    assert frame.raw.mean() * frame.unit == pytest.approx(0.2, abs=1e-4)
    with pytest.raises(ValueError, match="read-only"):
        frame.raw[0, 0] = 0


def test_a_new_run_takes_what_another_camera_tells(camera):
    device, stand_in = camera
    before = device.intrinsics
    stand_in.inject("exchange")
    anew(device)
    assert device.intrinsics != before


# --- processes that are killed


@pytest.mark.parametrize(
    ("ending", "said"), [(signal.SIGKILL, "ended by SIGKILL"), (signal.SIGSTOP, "no sign of life|hangs|SIGALRM")]
)
def test_a_process_that_is_killed_or_hangs_is_a_loss_and_a_new_run_has_another(camera, ending, said):
    device, _ = camera
    first = device.driver.process
    os.kill(first, ending)
    with pytest.raises(DeviceLost, match=said):
        raise fault_of(device)
    eventually(lambda: not Path(f"/proc/{first}").exists())
    anew(device)
    assert device.driver.process not in (None, first)


RUN = """
import sys, time
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
print(open_cell(load_cell(sys.argv[1]), now=time.monotonic).devices["camera"].driver.process, flush=True)
time.sleep(60)
"""


def test_killing_the_run_leaves_no_process(stand_in, live_cell):
    _, places = stand_in("realsense")
    path = live_cell("realsense", "depth", places["depth"])
    with subprocess.Popen([sys.executable, "-c", RUN, str(path)], stdout=subprocess.PIPE) as process:
        driver = json.loads(process.stdout.readline())
        process.kill()
    eventually(lambda: not Path(f"/proc/{driver}").exists() or "zombie" in Path(f"/proc/{driver}/status").read_text())
