"""`status` and `doctor` as a person gives them."""

import json
import os
import re

import pytest
from lab import lab_cell

from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.realsense.library import library

#: an address that no other test has, because the clients of a UR controller have their ports built in
HOST = f"127.1.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
LAB = {"arm": {"watchdog": "1 Hz", "lost_after": "2 s", "heartbeat": "5 s"}, "gripper": {"use": "robotiq_urcap"}}


@pytest.fixture
def cell(tmp_path):
    """A cell on stand-ins, as a file, and the stand-ins."""
    made = {name: stand_in_class(name)(HOST, StandInWorld()) for name in ("ur", "urcap")}
    for one in made.values():
        one.start()
    (tmp_path / "lab.yaml").write_text(lab_cell(HOST, LAB))
    yield made
    for one in made.values():
        one.stop()


def test_status_reads_and_takes_nothing_into_use(cli, cell):
    code, out, err = cli("status", "lab.yaml", "--json")
    assert (code, err) == (0, "")
    arm, gripper = json.loads(out)
    assert set(arm) == {"check", "ok", "detail", "fix"}
    assert arm["ok"]
    assert re.match(r"hand at -?0\.0, -?0\.0, 200\.0 mm, turned by 0\.0 deg; force \d+\.\d\d N", arm["detail"])
    assert gripper["detail"].startswith("opening 5")
    assert not any("program" in event for event in cell["ur"].state()["events"])


def test_doctor_says_what_keeps_devices_from_moving(cli, cell):
    code, out, _ = cli("doctor", "lab.yaml", "--json")
    found = {row["check"]: row for row in json.loads(out)}
    assert code == 3
    assert [name for name, row in found.items() if not row["ok"]] == ["gripper: ready"]
    assert "stretch-bt activate" in found["gripper: ready"]["detail"]
    assert "Robotmode: RUNNING" in found["arm: controller"]["detail"]
    assert found["arm: speed slider"]["detail"] == "100 %"
    assert "corners of the limits are out of reach" in found["arm: reach"]["detail"]
    assert cell["ur"].state()["moved"] == 0.0
    assert not cell["urcap"].state()["moving"]
    cell["ur"].inject("slider", {"fraction": 0.5})
    code, out, _ = cli("doctor", "lab.yaml", "--device", "arm")
    assert (code, "no  arm: speed slider: 50 %\n    set it to 100 % at the pendant" in out) == (3, True)
    cell["ur"].clear()
    cell["ur"].inject("protective_stop")
    code, out, _ = cli("doctor", "lab.yaml", "--device", "arm")
    assert code == 3
    assert re.search(r"no  arm: controller: .*PROTECTIVE_STOP\n    look at the pendant", out)
    assert "no  arm: reading: arm: protective stop: look for its cause" in out


def test_a_device_that_is_not_there_is_told_with_what_to_check(cli, tmp_path):
    (tmp_path / "lab.yaml").write_text(lab_cell("127.0.0.251", LAB))
    code, out, _ = cli("doctor", "lab.yaml", "--device", "arm")
    assert code == 3
    assert "no answer at 127.0.0.251 port 29999 (dashboard)" in out
    assert "check cable, address" in out
    code, out, _ = cli("status", "lab.yaml", "--device", "gripper")
    assert code == 3
    assert "no  gripper: gripper: it does not answer" in out


def test_a_simulated_cell_has_nothing_to_look_at(cli):
    for command in ("status", "doctor"):
        code, out, _ = cli(command, "simulated")
        assert (code, "nothing to connect to" in out) == (0, True)
    code, _, err = cli("status", "simulated", "--device", "amr")
    assert (code, "the cell has no device 'amr'" in err) == (2, True)


@pytest.mark.parametrize("host", ["", "tcp://192.168.1.10", "192.168.1.10:30004", "a b"])
def test_what_is_no_address_does_not_pass_a_check(cli, tmp_path, host):
    (tmp_path / "lab.yaml").write_text(lab_cell(host, LAB))
    code, out, _ = cli("check", "lab.yaml")
    assert code == 2
    assert out.count("is no address; write a name or an address alone") == 2


CAMERA = "format: stretch-cell/1\ndevices:\n  camera: {type: DepthCamera, use: realsense, "


@pytest.fixture
def librealsense():
    """Skip on a machine for which there is no librealsense."""
    try:
        library()
    except ImportError as error:
        pytest.skip(str(error))


def test_a_camera_is_looked_at_from_its_port_to_its_frames(cli, tmp_path, librealsense):
    made = stand_in_class("realsense")("127.0.0.1", StandInWorld(), {"depth": 0})
    host, _, port = made.start()["depth"].partition(":")
    try:
        (tmp_path / "lab.yaml").write_text(f"{CAMERA}host: {host}, port: {port}}}\n")
        code, out, _ = cli("status", "lab.yaml", "--json")
        assert (code, json.loads(out)[0]["detail"]) == (0, "frames of 320 x 240")
        code, out, _ = cli("doctor", "lab.yaml", "--json")
        found = {row["check"]: row["detail"] for row in json.loads(out)}
        assert list(found) == ["cell", "camera: source", "camera: reading", "camera: ready"]
        assert f"{host} port {port} answers" in found["camera: source"]
        assert "readings/s" in found["camera: reading"]
    finally:
        made.stop()
    code, out, _ = cli("doctor", "lab.yaml")
    assert code == 3
    assert "no  camera: source: no answer at" in out
    assert "begin stretch-bt emulate realsense" in out


def test_a_camera_that_is_not_connected_is_told_with_those_that_are(cli, tmp_path, librealsense):
    (tmp_path / "lab.yaml").write_text(f"{CAMERA}serial: '0042'}}\n")
    code, out, _ = cli("doctor", "lab.yaml")
    assert code == 3
    assert "no  camera: source: no camera 0042; connected: " in out
    assert "the extra sr305" in out
    (tmp_path / "play.yaml").write_text(f"{CAMERA}file: gone.db3}}\n")
    code, out, _ = cli("check", "play.yaml")
    assert (code, "no file 'gone.db3'" in out) == (2, True)


def test_a_library_that_is_missing_is_told_with_what_installs_it(cli, tmp_path, monkeypatch):
    monkeypatch.setattr("stretch_bt.hardware.examine.find_spec", lambda name: None)
    (tmp_path / "lab.yaml").write_text(f"{CAMERA}serial: '0042'}}\n")
    code, out, _ = cli("doctor", "lab.yaml")
    assert code == 3
    assert "no  camera: packages: not installed: pyrealsense2\n    pip install 'stretch-bt[realsense]'" in out
