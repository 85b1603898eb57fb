"""The box mask that isolates the membrane, and the average of still frames."""

import dataclasses
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics, Pose
from stretch_bt.perception import average_frames, mask_membrane

INTRINSICS = Intrinsics(400.0, 400.0, 99.5, 119.5, 200, 240)


def frame(raw, **changes):
    return DepthFrame(np.asarray(raw, np.uint16), 0.000125, INTRINSICS, 1.0, 7, plane_distance=0.2, **changes)


@given(stretch=st.floats(0, 0.08), gauge=st.floats(0.05, 0.1), width=st.floats(0.04, 0.09))
def test_the_box_follows_the_gripper(stretch, gauge, width):
    masked = mask_membrane(frame(np.full((240, 200), 1600)), gauge=gauge, width=width, stretch=stretch)
    v, u = np.nonzero(masked.raw)
    metres = 0.2 / 400.0
    length = min(gauge + stretch, 240 * metres + 0.008) - 0.008
    across = min(width / np.sqrt((gauge + stretch) / gauge), 200 * metres + 0.008) - 0.008
    assert (np.ptp(v) + 1) * metres == pytest.approx(length, abs=1.5 * metres)
    assert (np.ptp(u) + 1) * metres == pytest.approx(across, abs=1.5 * metres)
    assert masked.raw[v, u].tolist() == [1600] * len(v)


def test_a_mask_needs_to_know_where_the_membrane_is():
    bare = dataclasses.replace(frame(np.ones((240, 200))), plane_distance=None)
    with pytest.raises(InvalidInput, match="plane_distance"):
        mask_membrane(bare, gauge=0.1, width=0.09, stretch=0.0)
    with pytest.raises(InvalidInput, match="positive"):
        mask_membrane(frame(np.ones((240, 200))), gauge=0.1, width=0.0, stretch=0.0)


def test_averaging_gains_what_quantisation_lost():
    rng = np.random.default_rng(0)
    truth = 0.1999
    frames = [frame(np.rint((truth + rng.normal(0, 2e-4, (240, 200))) / 0.000125)) for _ in range(16)]
    mean = average_frames(frames)
    assert mean.unit == 0.000125 / 16
    assert (mean.time, mean.sequence) == (1.0, 7)
    assert mean.depth.std() == pytest.approx(2e-4 / 4, rel=0.1)
    assert mean.depth.mean() == pytest.approx(truth, abs=2e-6)


def test_a_pixel_needs_half_of_the_frames():
    stack = np.full((4, 240, 200), 800)
    stack[:2, 0, 0] = 0
    stack[:3, 0, 1] = 0
    mean = average_frames([frame(raw) for raw in stack])
    assert mean.raw[0, 0] == mean.raw[5, 5] == 800 * 16
    assert mean.raw[0, 1] == 0


def test_far_frames_keep_their_unit():
    assert average_frames([frame(np.full((240, 200), 60000))] * 2).raw.max() == 60000


@pytest.mark.parametrize(
    ("far", "plane", "finer"),
    [(0, 0.2, 16), (65535, 0.2, 16), (5000, 0.2, 16), (5000, None, 13), (65535, None, 1), (65535, 4.0, 8)],
)
def test_a_pixel_far_behind_the_hand_does_not_round_its_mean(far, plane, finer):
    raws = np.random.default_rng(0).integers(1600, 1602, (16, 240, 200))
    raws[:, 0, 0] = far
    if plane == 4.0:
        raws[:, 0, 1] = 8000
    mean = average_frames([dataclasses.replace(frame(raw), plane_distance=plane) for raw in raws])
    assert mean.unit == pytest.approx(0.000125 / finer)
    assert np.abs(mean.depth[1:] / 0.000125 - raws.mean(axis=0)[1:]).max() <= 0.51 / finer
    fits = far * finer <= 65535
    assert mean.raw[0, 0] == (far * finer if fits else 0)


def test_frames_of_two_cameras_are_not_averaged():
    other = dataclasses.replace(frame(np.ones((240, 200))), unit=0.001)
    for frames in ([], [frame(np.ones((240, 200))), other]):
        with pytest.raises(InvalidInput):
            average_frames(frames)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_hand_that_went_aside_has_no_mean(axis):
    places = [tuple(0.02 * k if i == axis else 0.0 for i in range(3)) for k in range(2)]
    with pytest.raises(IllConditioned, match=f"{'xy'[axis]} of the hand goes from 0.0 to 20.0 mm"):
        average_frames([frame(np.full((240, 200), 1600), pose=Pose(place)) for place in places])


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"pose": Pose(rotation=(0.0, 0.0, 1.5))}, "turns by 85.9 degrees"),
        ({"pose": Pose(rotation=(0.03, 0.0, 0.0))}, "turns by 1.7 degrees"),
        ({"plane_distance": 0.19}, "distance of the flat membrane goes from 190.0 to 200.0 mm"),
        ({"pose": Pose(rotation=(0.01, 0.0, 0.0))}, None),
        ({"pose": None}, None),
        ({"plane_distance": None}, None),
    ],
)
def test_a_hand_that_turned_or_a_plane_that_moved_has_no_mean(changed, why):
    frames = [frame(np.full((240, 200), 1600), pose=Pose()) for _ in range(2)]
    frames.insert(1, dataclasses.replace(frames[0], **changed))
    if why is None:
        assert average_frames(frames).raw.all()
    else:
        with pytest.raises(IllConditioned, match=re.escape(why)):
            average_frames(frames)


def test_an_image_without_pixels_has_a_mean_without_pixels():
    nothing = DepthFrame(np.zeros((0, 0), np.uint16), 0.000125, Intrinsics(1.0, 1.0, 0.0, 0.0, 0, 0), 1.0, 7)
    assert average_frames([nothing, nothing]).raw.shape == (0, 0)
