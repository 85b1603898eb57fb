from pathlib import Path

import cv2
import numpy as np
import pytest

from stretch_bt import run
from stretch_bt.errors import CellError, DeviceFault, DeviceLost, InvalidInput, NotReady
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import DeviceState
from stretch_bt.hardware.replay.frames import png_files
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.replay import replay

DATA = Path(__file__).parents[2].parent / "shared" / "data"


def test_the_latest_frame_at_each_time(record, clock):
    """The recording starts when the cell is opened, whatever its own clock said."""
    clock.time = 7.0
    cell = open_cell(load_cell(record()), now=clock)
    camera, sensor = cell.devices["camera"], cell.devices["force_sensor"]
    seen = []
    while not camera.ended:
        frame, wrench = camera.frame(1.0), sensor.wrench(1.0)
        np.testing.assert_array_equal(frame.value.raw, record.arrays["z"][frame.sequence])
        assert frame.device_time == frame.value.time == pytest.approx(100 + frame.sequence / 10)
        assert 0 <= clock.time - frame.host_time < 0.1 + 1e-6
        assert wrench.value.force == (wrench.sequence,) * 3
        seen.append(frame.sequence)
        clock.time += 0.03
    assert sorted(set(seen)) == [0, 1, 2, 3, 4]
    assert 7.5 <= clock.time < 7.56


@pytest.mark.parametrize(("device", "reading"), [("camera", "frame"), ("force_sensor", "wrench")])
def test_after_the_end_the_device_is_lost(record, clock, device, reading):
    cell = open_cell(load_cell(record()), now=clock)
    clock.time += 10.0
    with pytest.raises(DeviceLost, match="end of recording"):
        getattr(cell.devices[device], reading)(100.0)


def test_opening_again_plays_from_the_start(record, clock):
    cell = open_cell(load_cell(record()), now=clock)
    camera = cell.devices["camera"]
    clock.time += 0.35
    assert camera.frame(1.0).sequence == 3
    camera.close()
    clock.time += 5.0
    camera.open()
    assert camera.frame(1.0).sequence == 0


def test_intrinsics_are_those_of_the_kept_part(record, clock):
    intrinsics = open_cell(load_cell(record()), now=clock).devices["camera"].intrinsics
    assert (intrinsics.cx, intrinsics.cy, intrinsics.width, intrinsics.height) == (2.0, 2.0, 8, 6)


def test_zero_is_taken_off(record, clock):
    sensor = open_cell(load_cell(record()), now=clock).devices["force_sensor"]
    clock.time += 0.25
    sensor.zero()
    clock.time += 0.1
    assert sensor.wrench(1.0).value.force == (1.0, 1.0, 1.0)


BAD_ARRAYS = [
    ({"z": np.zeros((5, 6, 8))}, "float64 images"),
    ({"z": np.zeros((4, 6, 8), np.uint16)}, r"\(4, 6, 8\)"),
    ({"z": np.zeros((5, 6, 9), np.uint16)}, r"\(5, 6, 9\)"),
    ({"z": np.uint16(3)}, "images of shape"),
    ({"t": np.zeros(5)}, "do not rise"),
    ({"t": np.array([0, 1, np.nan, 3, 4])}, "finite"),
    ({"t": np.zeros(0)}, r"shape \(0, 6, 8\)"),
    ({"K": np.ones(3)}, "four finite numbers"),
    ({"K": np.zeros(4)}, "focal lengths are above 0"),
    ({"roi": np.array([1.0, 7.0, 2.0, np.inf])}, "four finite numbers"),
    ({"wrench": np.zeros((5, 3))}, r"must be \(5, 6\)"),
    ({"wrench": np.full((5, 6), np.nan)}, "finite"),
]


@pytest.mark.parametrize(("changes", "said"), BAD_ARRAYS)
def test_arrays_that_do_not_fit_are_mistakes_of_the_cell_file(record, changes, said):
    """They were faults of the device, once a run had begun."""
    with pytest.raises(CellError, match=said):
        load_cell(record(**changes))


@pytest.mark.parametrize(("changes", "said"), BAD_ARRAYS)
def test_arrays_that_no_longer_fit_are_refused_on_opening(record, clock, changes, said):
    spec = load_cell(record())
    record(**changes)
    with pytest.raises((DeviceLost, InvalidInput), match=said):
        open_cell(spec, now=clock)


def test_arrays_of_objects_are_refused_before_opening(record):
    with pytest.raises(CellError, match="it holds object, not numbers"):
        load_cell(record(z=np.array([None], object)))


def test_a_damaged_archive_is_refused(record, clock, tmp_path):
    spec = load_cell(record())
    content = bytearray((tmp_path / "press.npz").read_bytes())
    content[60:120] = bytes(60)
    (tmp_path / "press.npz").write_bytes(content)
    with pytest.raises(DeviceFault, match="cannot be read"):
        open_cell(spec, now=clock)


@pytest.fixture
def folder(tmp_path):
    for number, name in enumerate(("a_2", "a_10", "a_1")):
        cv2.imwrite(str(tmp_path / f"{name}.png"), np.full((3, 4), number, np.uint16))
    (tmp_path / "cell.yaml").write_text(
        "format: stretch-cell/1\ndevices:\n  camera: {type: DepthCamera, use: replay, folder: ., unit: 1 mm, rate: 10 Hz, "
        "width: 4, height: 3, intrinsics: {fx: 5, fy: 5, cx: 2, cy: 1.5}, plane_distance: 200 mm}\n"
    )
    return tmp_path


def test_a_folder_plays_in_the_order_of_counting(folder, clock):
    assert [path.stem for path in png_files(folder)] == ["a_1", "a_2", "a_10"]
    camera = open_cell(load_cell(folder / "cell.yaml"), now=clock).devices["camera"]
    seen = []
    for _ in range(3):
        frame = camera.frame(1.0).value
        seen.append(int(frame.raw[0, 0]))
        clock.time += 0.1
    assert seen == [2, 0, 1]
    assert (frame.unit, frame.plane_distance) == (0.001, 0.2)


@pytest.mark.parametrize(
    ("image", "said"),
    [(np.zeros((3, 4), np.uint8), "uint8"), (np.zeros((4, 4), np.uint16), r"\(4, 4\)"), (None, "cannot be read")],
)
def test_images_that_do_not_fit_are_refused(folder, clock, image, said):
    path = folder / "a_1.png"
    if image is None:
        path.write_bytes(b"no image")
    else:
        cv2.imwrite(str(path), image)
    camera = open_cell(load_cell(folder / "cell.yaml"), now=clock).devices["camera"]
    with pytest.raises(DeviceLost, match=said):
        camera.frame(1.0)


def play(path, text, clock):
    path.write_text(f"format: stretch-cell/1\ndevices:\n{text}")
    return open_cell(load_cell(path), now=clock)


def test_a_recorded_press_plays_whole(tmp_path, clock):
    source = DATA / "membrane_press" / "punyo_press_z.npz"
    if not source.exists():
        pytest.skip("the recorded press is not here")
    text = (
        f"  camera: {{type: DepthCamera, use: replay, file: {source}, depth: z_0p1mm, time: t, unit: 0.1 mm, "
        f"intrinsics: K, roi: roi}}\n  wrench: {{type: ForceSensor, use: replay, file: {source}}}\n"
    )
    cell = play(tmp_path / "cell.yaml", text, clock)
    camera, arrays = cell.devices["camera"], np.load(source)
    seen = {}
    while not camera.ended:
        frame = camera.frame(0.3)
        seen[frame.sequence] = (frame.value, cell.devices["wrench"].wrench(0.3).value)
        clock.time += 0.02
    assert sorted(seen) == list(range(75))
    np.testing.assert_array_equal(seen[40][0].raw, arrays["z_0p1mm"][40])
    assert seen[40][1].force == pytest.approx(tuple(arrays["wrench"][40, :3]))
    assert seen[40][0].depth[seen[40][0].raw > 0].min() > 0.05
    assert camera.intrinsics.cx == pytest.approx(313.72 - 90)


def test_recorded_camera_frames_play_whole(tmp_path, clock):
    source = DATA / "sr305"
    if not source.exists():
        pytest.skip("the recorded frames are not here")
    text = (
        f"  camera: {{type: DepthCamera, use: replay, folder: {source}, unit: 0.125 mm, rate: 30 Hz, "
        "intrinsics: {fx: 476.007, fy: 476.007, cx: 313.683, cy: 242.755}}\n"
    )
    camera = play(tmp_path / "cell.yaml", text, clock).devices["camera"]
    seen = set()
    while not camera.ended:
        frame = camera.frame(0.3)
        depth = frame.value.depth
        assert depth.shape == (480, 640)
        assert 0.2 < np.median(depth[frame.value.raw > 0]) < 1.5
        assert np.all(depth[frame.value.raw == 0] == 0)
        seen.add(frame.sequence)
        clock.time += 0.01
    assert len(seen) == 12


LIFT = """\
format: stretch-tree/1
devices: {arm: Arm}
trees:
  main:
    guard: arm.force < 50 N and arm.height < 1 m
    sequence:
      - retract: {clearance: 8 mm, speed: 40 mm/s}
      - move_over: {x: 8 mm, y: 0 mm, speed: 40 mm/s}
"""


def test_the_record_of_a_robot_replays_alike_and_its_arm_plays_from_it(stand_in, live_cell, tmp_path, clock):
    _, places = stand_in("ur")
    (tmp_path / "lift.yaml").write_text(LIFT)
    result = run(tmp_path / "lift.yaml", cell=live_cell("ur", "rtde", places["rtde"]), out=tmp_path / "record")
    assert result.status == "SUCCESS"
    again = replay(tmp_path / "record")
    assert (again.identical, again.first_difference) == (True, None)
    assert again.decisions > 4
    reader = RecordReader(tmp_path / "record")
    handed = {}
    for tick, _ in reader.ticks:
        for _, name, reading in reader.readings(tick):
            handed.setdefault(reading.host_time, {})[name] = reading.value
    both = {time: values for time, values in handed.items() if {"pose", "wrench"} <= values.keys()}
    assert len(both) >= 2
    poses = [[*v["pose"].position, *v["pose"].rotation] for v in both.values()]
    wrenches = [[*v["wrench"].force, *v["wrench"].torque] for v in both.values()]
    np.savez(tmp_path / "arm.npz", t=list(both), pose=poses, wrench=wrenches)
    arm = play(tmp_path / "cell.yaml", "  arm: {type: Arm, use: replay, file: arm.npz}\n", clock).devices["arm"]
    seen = []
    for due in np.array(list(both)) - next(iter(both)):
        clock.time = due + 1e-6
        seen.append(arm.pose(1.0).value)
    assert seen == [values["pose"] for values in both.values()]
    with pytest.raises(NotReady, match="a recording cannot be moved"):
        arm.move(Pose((0, 0, 0.2)), speed=0.05, owner="a")
    assert arm.state is DeviceState.READY
