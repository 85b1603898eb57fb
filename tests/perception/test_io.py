import cv2
import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Intrinsics
from stretch_bt.perception import deproject, load_depth_png, load_depth_stack

LENS = Intrinsics(50.0, 50.0, 3.5, 2.5, 8, 6)
SR305 = Intrinsics(476.007, 476.007, 313.683, 242.755, 640, 480)


def test_a_png_comes_back_as_it_was_written(tmp_path):
    raw = np.random.default_rng(0).integers(0, 65536, (6, 8)).astype(np.uint16)
    path = tmp_path / "depth.png"
    cv2.imwrite(str(path), raw)
    frame = load_depth_png(path, unit=0.125e-3, intrinsics=LENS, time=2.5, sequence=7)
    np.testing.assert_array_equal(frame.raw, raw)
    assert (frame.unit, frame.time, frame.sequence) == (0.125e-3, 2.5, 7)


def test_a_stack_comes_back_frame_by_frame(tmp_path):
    raw = np.arange(3 * 6 * 8, dtype=np.uint16).reshape(3, 6, 8)
    np.savez(tmp_path / "stack.npz", z=raw, t=[0.0, 0.1, 0.2])
    frames = list(load_depth_stack(tmp_path / "stack.npz", unit=1e-4, intrinsics=LENS, key="z", times="t"))
    assert [f.time for f in frames] == [0.0, 0.1, 0.2]
    assert [f.sequence for f in frames] == [0, 1, 2]
    np.testing.assert_array_equal([f.raw for f in frames], raw)
    again = load_depth_stack(tmp_path / "stack.npz", unit=1e-4, intrinsics=LENS, key="z", times=[1, 2, 3])
    assert [f.time for f in again] == [1.0, 2.0, 3.0]


def test_all_real_sr305_frames_load_with_unit_invalid_pixels_and_intrinsics(data):
    paths = sorted((data / "sr305").glob("*.png"))
    assert len(paths) == 12
    for number, path in enumerate(paths):
        frame = load_depth_png(path, unit=0.125e-3, intrinsics=SR305, sequence=number)
        points, valid = deproject(frame)
        np.testing.assert_array_equal(valid, frame.raw > 0)
        assert 0.0 < valid.mean() < 1.0
        assert frame.depth.max() <= 65535 * 0.125e-3
        assert 0.4 < np.median(points[valid][:, 2]) < 1.5
        v, u = np.argwhere(valid)[len(points) // 2]
        depth = frame.raw[v, u] * 0.125e-3
        expected = [(u - 313.683) / 476.007 * depth, (v - 242.755) / 476.007 * depth, depth]
        np.testing.assert_allclose(points[v, u], expected, rtol=1e-5)


def write_png(image):
    return lambda path: path.write_bytes(cv2.imencode(".png", image)[1].tobytes())


@pytest.mark.parametrize(
    ("write", "said"),
    [
        (lambda path: None, "cannot be read"),
        (lambda path: path.mkdir(), "cannot be read"),
        (lambda path: path.write_bytes(b""), "no image"),
        (lambda path: path.write_bytes(b"not a png"), "no image"),
        (write_png(np.zeros((6, 8), dtype=np.uint8)), "uint8"),
        (write_png(np.zeros((6, 8, 3), dtype=np.uint16)), "one channel"),
        (write_png(np.zeros((7, 8), dtype=np.uint16)), "fits these intrinsics"),
    ],
)
def test_files_that_are_no_depth_image_are_refused(tmp_path, write, said):
    path = tmp_path / "depth.png"
    write(path)
    with pytest.raises(InvalidInput, match=said):
        load_depth_png(path, unit=1e-4, intrinsics=LENS)


GOOD = {"z": np.zeros((2, 6, 8), dtype=np.uint16), "t": [0.0, 0.1]}


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        (None, "npz file"),
        ({"t": [0.0]}, "z"),
        ({"z": GOOD["z"]}, "t"),
        ({"z": np.zeros((2, 6, 8)), "t": [0.0, 0.1]}, "float64"),
        ({"z": GOOD["z"], "t": [0.0]}, "2 frames and 1 times"),
        ({"z": np.array([{}], dtype=object), "t": [0.0]}, "npz file"),
    ],
)
def test_files_that_are_no_stack_are_refused_before_the_first_frame(tmp_path, arrays, said):
    path = tmp_path / "stack.npz"
    if arrays is None:
        path.write_bytes(b"PK\x03\x04 broken")
    else:
        np.savez(path, **arrays)
    with pytest.raises(InvalidInput, match=said):
        load_depth_stack(path, unit=1e-4, intrinsics=LENS, key="z", times="t")


@pytest.mark.parametrize(
    ("times", "said"),
    [
        (["a", "b"], "times are"),
        ([[0.0], [0.0, 0.1]], "times"),
        ([None, 0.1], "times"),
        (np.zeros((2, 2)), r"one time for each frame.*\(2, 2\)"),
        (0.5, r"one time for each frame.*\(\)"),
        ("z", r"one time for each frame.*\(2, 6, 8\)"),
        ("words", "times"),
    ],
)
def test_times_that_are_no_row_of_numbers_are_refused_before_the_first_frame(tmp_path, times, said):
    np.savez(tmp_path / "stack.npz", **GOOD, words=np.array(["a", "b"]))
    with pytest.raises(InvalidInput, match=said):
        load_depth_stack(tmp_path / "stack.npz", unit=1e-4, intrinsics=LENS, key="z", times=times)


@pytest.mark.parametrize("unit", [0.0, -1e-4, 1.0, float("nan")])
def test_a_unit_that_is_not_metres_a_count_is_refused(tmp_path, unit):
    with pytest.raises(InvalidInput, match="metres"):
        load_depth_png(tmp_path / "x.png", unit=unit, intrinsics=LENS)
