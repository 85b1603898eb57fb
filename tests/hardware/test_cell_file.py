import json
import subprocess
import sys
from importlib.resources import files
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from stretch_bt.errors import CellError
from stretch_bt.hardware.cell_file import cell_names, cell_schema, load_cell
from stretch_bt.hardware.limits import Limits
from stretch_bt.source import load

GOOD = """\
format: stretch-cell/1
doc: A cell.
devices:
  arm: {type: Arm, use: simulated, acceleration: 0.5 m/s^2}
  gripper:
    type: Gripper
    use: simulated
    max_opening: 140 mm
  camera: {type: DepthCamera, use: simulated, rate: 30 Hz, image: membrane}
  tape:
    type: DepthCamera
    use: replay
    file: press.npz
    depth: z
    unit: 0.1 mm
    intrinsics: K
  wrench: {type: ForceSensor, use: replay, file: press.npz, wrench: w}
hand: {gauge: 100 mm, rest_opening: 55 mm}
limits:
  height: {min: 0 mm, max: 500 mm}
  speed: 250 mm/s
  depth: 25 mm
  force: 20 N
"""

# (what is written, what instead of it, line, column, part of the message, part of the hint)
MISTAKES = [
    ("stretch-cell/1", "stretch-cell/2", 1, 9, "format", "stretch-cell/1"),
    ("type: Arm", "type: Arms", 4, 15, "no device type 'Arms'", "Arm"),
    ("type: Arm, ", "", 4, 8, "type is missing", "add 'type"),
    ("use: simulated, acc", "use: robot, acc", 4, 25, "no Arm called 'robot'", "simulated"),
    ("acceleration: 0.5 m/s^2", "acceleration: 0.5 m/s", 4, 50, "Speed, not Acceleration", "m/s^2"),
    ("acceleration", "accelaration", 4, 36, "unknown key", "acceleration"),
    ("use: simulated\n", "use: simulatd\n", 7, 10, "no Gripper called 'simulatd'", "simulated"),
    ("max_opening: 140 mm", "max_opening: 140", 8, 18, "no unit", "140 mm"),
    ("max_opening: 140 mm", "max_opening: 1.4 m", 8, 18, "1400 mm is out of bounds", "at most 500 mm"),
    ("image: membrane", "image: membran", 9, 67, "image", "membrane"),
    ("rate: 30 Hz", "rate: 30 s", 9, 53, "Time, not Frequency", "Hz"),
    ("file: press.npz\n", "file: pres.npz\n", 13, 11, "no file 'pres.npz'", "relative to the cell file"),
    ("file: press.npz\n", "file: text.npz\n", 13, 11, "not an npz file", "numpy.savez"),
    ("file: press.npz\n", "file: one.npy\n", 13, 11, "one array", "numpy.savez"),
    ("    file: press.npz\n", "    folder: empty\n", 11, 5, "holds no arrays", "fx, fy, cx, cy"),
    ("    file: press.npz\n", "", 11, 5, "one file or one folder", "file: ..."),
    ("    depth: z\n", "", 11, 5, "which array", "depth: NAME"),
    ("depth: z", "depth: zz", 14, 12, "no array 'zz'", "'z'"),
    ("unit: 0.1 mm", "unit: 0.1", 15, 11, "no unit", "0.1 mm"),
    ("intrinsics: K", "intrinsics: k", 16, 17, "no array 'k'", "'K'"),
    ("wrench: w}", "wrench: wrensh}", 17, 69, "no array 'wrensh'", ""),
    ("  wrench:", "  wr-ench:", 17, 3, "no name for a device", "letters"),
    ("gauge: 100 mm", "gauge: 100 kg", 18, 15, "Mass, not Length", "mm"),
    ("rest_opening", "rest_openning", 18, 23, "unknown key", "rest_opening"),
    ("min: 0 mm", "min: 600 mm", 20, 11, "not below max", "swap"),
    ("min: 0 mm, ", "", 20, 11, "min is missing", "add 'min"),
    ("speed: 250 mm/s", "speed: 0 mm/s", 21, 10, "out of bounds", "at least"),
    ("depth: 25 mm", "dept: 25 mm", 22, 3, "unknown key 'dept'", "depth"),
    ("force: 20 N", "force: twenty", 23, 10, "not a number", ""),
    ("limits:", "limit:", 19, 1, "unknown key 'limit'", "limits"),
]


@pytest.fixture
def folder(tmp_path):
    np.savez(
        tmp_path / "press.npz", z=np.zeros((1, 480, 640), np.uint16), K=np.ones(4), w=np.zeros((1, 6)), t=np.zeros(1)
    )
    (tmp_path / "text.npz").write_text("no archive")
    np.save(tmp_path / "one.npy", np.zeros(3))
    return tmp_path


@pytest.mark.parametrize(("right", "wrong", "line", "column", "said", "hint"), MISTAKES)
def test_each_mistake_is_found_at_its_place(folder, right, wrong, line, column, said, hint):
    assert right in GOOD
    path = folder / "cell.yaml"
    path.write_text(GOOD.replace(right, wrong, 1))
    with pytest.raises(CellError) as caught:
        load_cell(path)
    found = caught.value.diagnostics
    assert [(d.line, d.column) for d in found] == [(line, column)], found
    assert said in found[0].message
    assert hint in found[0].hint
    assert found[0].hint
    assert found[0].file == str(path)


WIRED = """\
format: stretch-cell/1
devices:
  gripper:
    type: Gripper
    use: robotiq
    serial: line
    model: 2f140
    calibration: {points: [{count: 3, opening: 140 mm}, {count: 230, opening: 0 mm}], source: a test}
  sensor:
    type: ForceSensor
    use: ati
    host: sensor
    calibration: {counts_per_newton: 1000000, counts_per_newton_metre: 1000000, source: a test}
"""
WIRED_MISTAKES = [
    ("    serial: line\n", "", 4, "one serial line or behind one host", "write `serial: ...` or `host: ...`"),
    ("    serial: line\n", "    serial: line\n    host: box\n", 7, "one serial line or behind one host", "serial"),
    ("2f140", "2f141", 7, "model", "2f140"),
    ("2f140\n", "2f140\n    slowest: 300 mm/s\n", 8, "is not below the fastest, 250 mm/s", "rise"),
    ("2f140\n", "2f140\n    fastest: 30 mm/s\n", 8, "the slowest speed, 30 mm/s", "rise"),
    (", source: a test}\n  sensor", "}\n  sensor", 8, "source is missing", "add 'source"),
    ("[{count: 3, opening: 140 mm}, ", "[", 8, "points", ""),
    ("opening: 0 mm", "opening: 150 mm", 8, "must fall as the count grows", ""),
    ("    host: sensor\n", "", 10, "host is missing", "add 'host"),
    ("counts_per_newton: 1000000, ", "", 13, "counts_per_newton is missing", ""),
]


@pytest.mark.parametrize(("right", "wrong", "line", "said", "hint"), WIRED_MISTAKES)
def test_mistakes_about_devices_on_wires(tmp_path, right, wrong, line, said, hint):
    path = tmp_path / "cell.yaml"
    path.write_text(WIRED)
    assert set(load_cell(path).devices) == {"gripper", "sensor"}
    assert right in WIRED
    path.write_text(WIRED.replace(right, wrong, 1))
    with pytest.raises(CellError) as caught:
        load_cell(path)
    found = caught.value.diagnostics
    assert len(found) == 1, found
    assert said in found[0].message
    assert hint in found[0].hint
    assert found[0].line == line


_ARM = {"type": "Arm", "use": "ur", "host": "robot", "base": {}, "hand": {}, "source": "a test"}
_UR5, _UR5E = {**_ARM, "model": "ur5"}, {**_ARM, "model": "ur5e"}
_CAMERA = {"type": "DepthCamera", "use": "realsense", "serial": "1"}
_COUNTS = {"counts_per_newton": 1000000, "counts_per_newton_metre": 1000000, "source": "a test"}
_SENSOR = {"type": "ForceSensor", "use": "ati", "host": "sensor", "calibration": _COUNTS}
# (a device, options that just work, one of them that does not, what is said)
TIMES = [
    (_UR5, {"rate": "125 Hz"}, ("rate", "126 Hz"), "a ur5 has 125 cycles a second, not 126"),
    (_UR5E, {"rate": "500 Hz"}, (), ""),
    (
        _UR5,
        {"rate": "40 Hz", "lost_after": "50 ms"},
        ("lost_after", "50 ms", "rate", "39 Hz"),
        "51.28 ms later at worst",
    ),
    (_UR5, {"rate": "17 Hz"}, ("rate", "10 Hz"), "news that comes 10 times a second"),
    (_UR5, {"rate": "20 Hz", "watchdog": "19 Hz"}, ("watchdog", "60 Hz"), "never keep a watchdog of 60 Hz quiet"),
    (_UR5, {"contact_force": "5 N"}, ("contact_force", "0.5 N"), "the noise of a ur5 passes 0.5 N"),
    (_UR5, {"contact_force": "2 N", "force_filter": "1 s"}, ("force_filter", "0.1 s"), "the noise of a ur5 passes 2 N"),
    (_UR5E, {"contact_force": "2 N"}, ("contact_force", "1 N"), "the noise of a ur5e passes 1 N"),
    (_CAMERA, {"rate": "6 Hz", "lost_after": "170 ms"}, ("lost_after", "100 ms"), "frames that come 6 times a second"),
    (
        _SENSOR,
        {"lost_after": "110 ms"},
        ("lost_after", "100 ms"),
        "asked for again after 100 ms, and lost after 100 ms",
    ),
]


@pytest.mark.parametrize(("device", "works", "wrong", "said"), TIMES)
def test_times_that_always_end_in_a_loss_and_noise_that_blocks_are_mistakes(tmp_path, device, works, wrong, said):
    path = tmp_path / "cell.yaml"

    def written(options):
        path.write_text("format: stretch-cell/1\ndevices: " + json.dumps({"one": {**device, **options}}) + "\n")
        return path

    load_cell(written(works))
    if wrong:
        changed = dict(zip(wrong[::2], wrong[1::2], strict=True))
        with pytest.raises(CellError, match=said) as caught:
            load_cell(written({**works, **changed}))
        assert [bool(one.hint) for one in caught.value.diagnostics] == [True]


def test_every_mistake_is_reported_in_one_pass_and_in_order(folder):
    path = folder / "cell.yaml"
    path.write_text(
        GOOD.replace("Arm,", "Armm,").replace("30 Hz", "30").replace("25 mm", "25").replace("depth: z", "depth: y")
    )
    with pytest.raises(CellError) as caught:
        load_cell(path)
    assert [d.line for d in caught.value.diagnostics] == [4, 9, 14, 22]


def test_the_good_cell_is_read_in_si(folder):
    (folder / "cell.yaml").write_text(GOOD)
    spec = load_cell(folder / "cell.yaml")
    assert spec.name == "cell"
    assert {n: (d.type, d.use) for n, d in spec.devices.items()}["tape"] == ("DepthCamera", "replay")
    assert spec.limits.speed == pytest.approx(0.25)
    assert spec.limits.stretch.max == pytest.approx(0.08)
    assert spec.hand.opening(0.02) == pytest.approx(0.075)
    assert spec.devices["arm"].mark.line == 4


@pytest.mark.parametrize(
    ("devices", "said"), [("{}", "devices"), ("[]", "devices"), ("{arm: 3}", "devices.arm"), ("3", "devices")]
)
def test_devices_that_are_none(tmp_path, devices, said):
    path = tmp_path / "cell.yaml"
    path.write_text(f"format: stretch-cell/1\ndevices: {devices}\n")
    with pytest.raises(CellError, match=said):
        load_cell(path)


def test_an_unknown_cell_is_refused():
    with pytest.raises(CellError, match="did you mean 'simulated'"):
        load_cell("simulatd")


@pytest.mark.parametrize("name", cell_names())
def test_shipped_cells_load_and_fit_the_schema(name):
    path = Path(str(files("stretch_bt"))) / "trees" / "cells" / f"{name}.yaml"
    jsonschema.validate(load(path).plain(), cell_schema())
    assert load_cell(name).name == name


def test_the_schema_knows_the_options_of_each_implementation(folder):
    (folder / "cell.yaml").write_text(GOOD)
    good = load(folder / "cell.yaml").plain()
    jsonschema.validate(good, cell_schema())
    for device, key in (("arm", "accelaration"), ("tape", "fil")):
        bad = {**good, "devices": {**good["devices"], device: {**good["devices"][device], key: "1 mm"}}}
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(bad, cell_schema())


def test_reading_a_cell_file_imports_no_simulation():
    """Whoever checks a file, or runs on a robot, does not pay for the twin."""
    code = (
        "import sys; from stretch_bt.hardware.cell_file import load_cell; load_cell('simulated').simulated; "
        "import stretch_bt.hardware.cell, stretch_bt.hardware.robotiq.gripper, stretch_bt.hardware.ati.force_sensor; "
        "assert not [m for m in sys.modules if m.startswith('stretch_bt.simulation') or m in ('cv2', 'scipy', 'pymodbus', 'serial')]"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_limits_come_back_from_what_a_record_has_of_them():
    limits = load_cell("lab_ur5").limits
    assert Limits.from_plain(json.loads(json.dumps(limits.model_dump()))) == limits
    assert Limits.from_plain({"depth": 0.01}) == Limits().model_copy(update={"depth": 0.01})
