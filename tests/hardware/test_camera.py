"""A camera opened: its recordings, and what cannot be opened."""

import os
import signal
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
from waiting import broken_off, eventually

from stretch_bt.errors import CellError, DeviceLost, MissingExtra, NotReady
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.driver import CellContext
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.implementations import driver_class
from stretch_bt.hardware.realsense.library import library

try:
    library()
except ImportError as error:
    pytest.skip(str(error), allow_module_level=True)


def test_what_was_recorded_is_played_at_its_pace_and_ends(stand_in, clock, live_cell, tmp_path, monkeypatch):
    clock.runs = True  # on one that stands, each frame comes later after the one before
    _, places = stand_in("realsense")
    path = live_cell("realsense", "depth", places["depth"], record="kept")
    cell = open_cell(load_cell(path), now=time.monotonic)
    eventually(lambda: cell.devices["camera"].frame(1e9).sequence > 45)
    unit = cell.devices["camera"].frame(1e9).value.unit
    assert cell.close() == []
    (kept,) = (tmp_path / "kept").iterdir()
    (tmp_path / "play.yaml").write_text(
        f"format: stretch-cell/1\ndevices: {{camera: {{type: DepthCamera, use: realsense, file: kept/{kept.name}, lost_after: 2 s}}}}\n"
    )
    cell = open_cell(load_cell(tmp_path / "play.yaml"), now=time.monotonic)
    try:
        camera, times = cell.devices["camera"], {}
        first = camera.frame(1e9)
        assert first.value.unit == unit
        assert camera.intrinsics.fx == 238.0
        while not camera.ended:
            with suppress(DeviceLost):
                reading = camera.frame(1e9)
                times[reading.sequence] = (reading.device_time, reading.host_time)
            time.sleep(0.002)
        with pytest.raises(DeviceLost, match="end of recording"):
            camera.frame(1e9)
        device, host = zip(*times.values(), strict=True)
        assert len(times) >= 5
        assert 0.5 < (host[-1] - host[0]) / (device[-1] - device[0]) < 1.5
        stays_at_its_end(camera)
    finally:
        cell.close()


def stays_at_its_end(camera):
    """Assert that a recording which ended is not played again: not for its silence, nor as its process is killed."""
    first = camera.driver.process
    time.sleep(2.2)  # more than lost_after
    assert camera.driver.process == first
    os.kill(first, signal.SIGKILL)
    eventually(lambda: camera.driver.process is None)
    assert camera.ended
    with pytest.raises(DeviceLost, match="end of recording"):
        camera.frame(1e9)


def test_a_file_that_is_no_recording_is_told(tmp_path):
    (tmp_path / "no.db3").write_text("nothing")
    (tmp_path / "play.yaml").write_text(
        "format: stretch-cell/1\ndevices: {camera: {type: DepthCamera, use: realsense, file: no.db3}}\n"
    )
    with pytest.raises(DeviceLost, match=r"camera: no frames from the recording no.db3: \w+"):
        open_cell(load_cell(tmp_path / "play.yaml"), now=time.monotonic)


BAD_CELLS = [
    ("", "none is given; write one of 'serial"),
    ("serial: '1', host: localhost", "serial and host are given"),
    ("file: none.db3", "no file 'none.db3' beside the cell file"),
    ("host: 'a b'", "no address"),
    ("serial: '1', rate: 30", "'30 Hz'"),
    ("serial: ''", "serial is empty; write what it names"),
    ("file: a, record: b", r"error\[value\]: a recording is not recorded again"),
]


@pytest.mark.parametrize(("options", "said"), BAD_CELLS)
def test_cells_that_cannot_be(tmp_path, options, said):
    (tmp_path / "cell.yaml").write_text(
        f"format: stretch-cell/1\ndevices:\n  camera: {{type: DepthCamera, use: realsense, {options}}}\n"
    )
    with pytest.raises(CellError, match=said):
        load_cell(tmp_path / "cell.yaml")


def test_nobody_there_no_such_camera_and_a_library_that_is_missing(live_cell, tmp_path, monkeypatch):
    with pytest.raises(DeviceLost, match=r"no frames from 127.0.0.1 port 9: .*nobody answers at 127.0.0.1 port 9"):
        open_cell(load_cell(live_cell("realsense", "depth", "127.0.0.1:9")), now=time.monotonic)
    (tmp_path / "usb.yaml").write_text(
        "format: stretch-cell/1\ndevices: {camera: {type: DepthCamera, use: realsense, serial: '0042'}}\n"
    )
    with pytest.raises(DeviceLost, match="no camera has the serial number 0042; connected: "):
        open_cell(load_cell(tmp_path / "usb.yaml"), now=time.monotonic)
    (tmp_path / "pyrealsense2.py").write_text("raise ImportError('not here')")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingExtra, match=r"camera needs pyrealsense2: not here; .*stretch-bt\[realsense\].*sr305"):
        open_cell(load_cell(tmp_path / "usb.yaml"), now=time.monotonic)


def test_a_library_that_cannot_be_loaded_and_a_folder_that_cannot_be_are_told(
    stand_in, live_cell, tmp_path, monkeypatch
):
    _, places = stand_in("realsense")
    (tmp_path / "taken").write_text("no folder")
    with pytest.raises(DeviceLost, match=r"no folder can be made at .*taken .*: correct `record`"):
        open_cell(load_cell(live_cell("realsense", "depth", places["depth"], record="taken")), now=time.monotonic)
    (tmp_path / "pyrealsense2.py").write_text("raise ImportError('libusb-1.0.so.0: cannot open')")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingExtra, match=r"libusb-1.0.so.0: cannot open; install it with: pip install"):
        open_cell(load_cell(live_cell("realsense", "depth", places["depth"])), now=time.monotonic)


def test_ctrl_c_while_it_is_opened_leaves_no_process_and_no_thread(stand_in, live_cell):
    behind, places = stand_in("realsense")
    behind.inject("freeze")
    cell = load_cell(live_cell("realsense", "depth", places["depth"]))
    with broken_off(lambda: behind.state()["streaming"]):
        open_cell(cell, now=time.monotonic)
    assert "supervisor of camera" not in [thread.name for thread in threading.enumerate()]
    eventually(lambda: not behind.state()["streaming"])


def test_the_lens_is_not_known_before_the_camera_is_open(live_cell):
    spec = load_cell(live_cell("realsense", "depth", "127.0.0.1:9"))
    made = driver_class("DepthCamera", "realsense")(
        "camera", spec.devices["camera"].options, CellContext(time.monotonic, 0, Path(), Hand(), spec.limits)
    )
    with pytest.raises(NotReady, match="open it first"):
        _ = made.intrinsics
