"""Depth frames that are made by hand."""

import doctest

import numpy as np
import pytest

from stretch_bt import frames
from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench

CAMERA = Intrinsics(100.0, 100.0, 2.0, 1.5, 5, 4)
FLAT = np.full((4, 5), 0.1)


def test_metres_become_counts():
    depth = FLAT.copy()
    depth[1, 2], depth[2, 2], depth[2, 3] = 0.05, np.nan, -1.0
    made = DepthFrame.from_array(depth, CAMERA, unit=1e-4)
    assert made.raw.dtype == np.uint16
    assert (made.raw[0, 0], made.raw[1, 2], made.raw[2, 2], made.raw[2, 3]) == (1000, 500, 0, 0)
    assert made.plane_distance == pytest.approx(0.1)
    assert (made.pose, made.hand_height) == (Pose(), 0.0)


def test_whole_numbers_are_counts():
    made = DepthFrame.from_array(np.full((4, 5), 800), CAMERA, unit=1e-4, plane_distance=0.09, pose=Pose((0, 0, 0.2)))
    assert (made.raw[0, 0], made.plane_distance, made.hand_height) == (800, 0.09, 0.2)


#: a depth image, its unit, and what is said
WRONG = {
    "shape": (FLAT[0], 1e-4, r"is an array \(h, w\) of numbers, got float64 \(5,\)"),
    "size": (FLAT[:2], 1e-4, "fits these intrinsics"),
    "empty": (FLAT * 0, 1e-4, "no pixel of the depth image is valid"),
    "far": (FLAT * 1e3, 1e-4, "give depths in metres, or a larger unit"),
    "unit": (FLAT, 0.0, "unit is the depth of one count in metres"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_no_depth_image_is_refused(what):
    depth, unit, told = WRONG[what]
    with pytest.raises(InvalidInput, match=told):
        DepthFrame.from_array(depth, CAMERA, unit=unit)


def test_the_examples_run():
    found = doctest.testmod(frames)
    assert (found.failed, found.attempted > 0) == (0, True)


def test_lists_and_arrays_are_kept_as_tuples():
    """Coefficients come as a list from librealsense, which no cache could hash."""
    camera = Intrinsics(200.0, 200.0, 79.5, 79.5, 160, 160, [0.1, 0.0, 0.0, 0.0, 0.0])
    assert hash(camera) == hash(Intrinsics(200.0, 200.0, 79.5, 79.5, 160, 160, (0.1, 0.0, 0.0, 0.0, 0.0)))
    assert Pose(np.array([0.0, 0.0, 0.1])) == Pose((0.0, 0.0, 0.1))
    assert Wrench([0.0, 0.0, 1.0]) == Wrench((0.0, 0.0, 1.0))


def test_a_number_larger_than_any_float_is_refused():
    with pytest.raises(InvalidInput, match="six finite numbers"):
        Pose((10**400, 0, 0))


def test_depths_of_half_precision_are_not_counted_in_it():
    camera = Intrinsics(200.0, 200.0, 79.5, 79.5, 160, 160)
    counts = DepthFrame.from_array(np.full((160, 160), 0.1, np.float16), camera, unit=1e-5).raw
    assert int(counts[0, 0]) == round(float(np.float16(0.1)) / 1e-5)


@pytest.mark.parametrize(
    "given",
    [
        *(
            {name: wrong}
            for name in ("stretch", "hand_height", "plane_distance", "time")
            for wrong in (np.nan, np.inf, "30 mm", True)
        ),
        {"time": None},
        *({"sequence": wrong} for wrong in (np.nan, 1.5, None, "1", -1)),
    ],
    ids=str,
)
def test_a_frame_says_when_and_where_it_is_in_finite_numbers(given):
    told = {"unit": 1e-4, "intrinsics": CAMERA, "time": 0.0, "sequence": 0, **given}
    with pytest.raises(InvalidInput, match=next(iter(given))):
        DepthFrame(np.full((4, 5), 1000, np.uint16), **told)
