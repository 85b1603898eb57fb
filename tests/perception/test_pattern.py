"""The static error of a camera, learned from the free membrane, and its drift."""

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import Contact, FreeView, with_left_over, without_pattern
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.smooth import smooth
from stretch_bt.units import Estimate

LENS = Intrinsics(475.0, 475.0, 100.0, 110.0, 200, 220)
DISTANCE, GAUGE, UNIT = 0.2, 0.1, 1.25e-4


def uneven(sd, kernel, rng):
    """Return a smooth field (h, w), m, of a standard deviation."""
    field, _ = smooth(rng.standard_normal((220, 200)).astype(np.float32), np.ones((220, 200), np.float32), kernel)
    return sd * (field - field.mean()) / field.std()


def frame(depth, number=0, rate=0.0, **more):
    """Return a frame of a depth image, the camera of which drifts at a rate, m/s."""
    raw = np.rint((depth + rate * number / 30.0) / UNIT).astype(np.uint16)
    given = {"unit": UNIT, "intrinsics": LENS, "plane_distance": DISTANCE, "stretch": 0.0, **more}
    return DepthFrame(raw=raw, time=number / 30.0, sequence=number, **given)


def learned(pattern, hang=0.0, rate=0.0, count=150, noise=1e-4, seed=0):
    rng = np.random.default_rng(seed)
    along = (np.arange(220) - LENS.cy)[:, None] / LENS.fy * DISTANCE
    free = DISTANCE + hang * (1.0 - (2.0 * along / GAUGE) ** 2) + pattern
    view = FreeView()
    for number in range(count):
        view.add(frame(free + rng.normal(0.0, noise, free.shape), number, rate))
    return view


@pytest.mark.parametrize("changed", [{"stretch": 5e-3}, {"stretch": None}, {"plane_distance": DISTANCE + 4e-3}])
def test_a_view_takes_frames_of_one_membrane_alone(changed):
    view, depth = FreeView(), np.full((220, 200), DISTANCE)
    view.add(frame(depth))
    view.add(frame(depth, 1, stretch=1e-3))
    with pytest.raises(InvalidInput, match="begin a new view"):
        view.add(frame(depth, 2, **changed))


@pytest.mark.parametrize("hang", [0.2e-3, 0.7e-3])
def test_a_hang_that_is_known_is_not_taken_for_a_static_error_of_its_shape(hang):
    rng = np.random.default_rng(5)
    for _ in range(4):
        found = learned(uneven(0.5e-3, 20.0, rng), hang=hang).pattern(GAUGE, Estimate(hang, 3e-5))
        assert abs(found.hang - hang) < 3 * found.hang_sd


@pytest.mark.parametrize("told", [0.0, 3e-3])
def test_a_hang_that_is_told_wrong_by_far_is_not_believed(told):
    found = learned(uneven(0.1e-3, 20.0, np.random.default_rng(6)), hang=1.2e-3).pattern(GAUGE, Estimate(told, 3e-5))
    assert abs(found.hang - 1.2e-3) < 0.2e-3


def test_free_sides_that_hang_lower_are_no_static_error():
    across = (np.arange(LENS.width) - LENS.cx) / LENS.fx * DISTANCE
    along = (np.arange(LENS.height) - LENS.cy)[:, None] / LENS.fy * DISTANCE
    lower = 0.13 * (2 * across / 0.09) ** 2 * 0.6e-3 * (1.0 - (2.0 * along / GAUGE) ** 2)
    view = learned(np.where(np.abs(across) < 0.045, lower, 0.0), hang=0.6e-3)
    middle = np.abs(across) < 0.04
    known, unknown = (
        view.pattern(GAUGE, Estimate(0.6e-3, 3e-5), width).error[90:130][:, middle] for width in (0.09, np.inf)
    )
    assert np.abs(known).max() < 0.03e-3 < np.abs(unknown).max()


def test_a_pattern_is_taken_off_and_what_the_membrane_hangs_is_not():
    pattern = uneven(0.3e-3, 20.0, np.random.default_rng(1))
    found = learned(pattern, hang=0.4e-3).pattern(GAUGE)
    assert abs(found.hang - 0.4e-3) < 3 * found.hang_sd < 1e-3
    # What a hang hides of a pattern is of its own shape; the rest is found.
    along = (np.arange(220) - LENS.cy)[:, None] / LENS.fy * DISTANCE
    known = pattern + (0.4e-3 - found.hang) * (1.0 - (2.0 * along / GAUGE) ** 2)
    missed = (known - found.error)[20:-20, 20:-20]
    assert missed.std() < 0.01e-3
    assert found.left < 0.02e-3
    cleaned = without_pattern(frame(0.19 + pattern), found)
    assert cleaned.unit == pytest.approx(UNIT / 16)
    left = cleaned.depth - 0.19 - (pattern - found.error)
    assert np.abs(left).max() < 0.6 * UNIT


@pytest.mark.parametrize("far", [4000, 5000, 65535])
def test_a_pixel_far_behind_the_hand_does_not_keep_a_pattern_on_it(far):
    small = Pattern(
        np.full((220, 200), 0.3 * UNIT, np.float32), np.zeros((220, 200), np.float32), 0.0, 0.0, 0.0, 0.0, 0.0
    )
    shot = frame(np.full((220, 200), 0.19))
    shot.raw[0, 0] = far
    removed = (shot.depth - without_pattern(shot, small).depth)[1:]
    assert removed == pytest.approx(0.3 * UNIT, abs=UNIT / 16)


@pytest.mark.parametrize("hang", [1.5e-3, 4e-3])
@pytest.mark.parametrize("seed", range(5))
def test_a_loose_membrane_that_hangs_far_is_believed(hang, seed):
    found = learned(uneven(0.5e-3, 20.0, np.random.default_rng(seed)), hang=hang, count=40).pattern(GAUGE)
    assert abs(found.hang - hang) < 3 * found.hang_sd
    assert found.hang_sd < 0.4e-3


def test_a_flat_membrane_before_a_perfect_camera_shows_no_pattern():
    found = learned(np.zeros((220, 200))).pattern(GAUGE)
    assert found.hang < 0.01e-3
    assert np.abs(found.error).max() < 0.02e-3


@pytest.mark.parametrize("rate", [-5e-6, 0.0, 3e-6])
def test_drift_is_taken_off_later_frames(rate):
    found = learned(np.zeros((220, 200)), rate=rate).pattern(GAUGE)
    late = without_pattern(frame(np.full((220, 200), 0.19), 900, rate), found)
    assert found.rate == pytest.approx(rate, abs=0.5e-6)
    assert late.depth.mean() == pytest.approx(0.19, abs=0.5 * UNIT + 0.02e-3)


def test_latest_frames_count_only_when_they_are_known_to_be_free():
    view = learned(np.zeros((220, 200)), count=10)
    assert view.pattern(GAUGE) is None
    view.settle()
    assert view.count == 10
    assert view.pattern(GAUGE).rate == 0.0, "ten frames show no drift"


@pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("left", [0.0, 1e-5, 1e-4])
def test_what_a_pattern_missed_counts_as_noise_of_the_whole_contact(noise, left):
    points, none = np.zeros((500, 3)), np.zeros((220, 200), np.float32)
    contact = Contact(
        points, points, np.zeros((2, 2), np.uint8), noise, None, None, 0.0, points, points, noise_area=3.0
    )
    found = with_left_over(contact, Pattern(none, none, left, 0.0, 0.0, 0.0, 0.0))
    assert found.noise == pytest.approx(np.hypot(noise, left))
    assert 1.0 <= found.noise_area <= 500.0 * (1 + 1e-9)
    of_mean = found.noise**2 * min(found.noise_area, 500) / 500
    assert of_mean == pytest.approx(noise**2 * 3.0 / 500 + left**2)


def test_what_does_not_fit_is_refused():
    view = learned(np.zeros((220, 200)), count=20)
    with pytest.raises(InvalidInput, match="unit or intrinsics"):
        view.add(frame(np.full((220, 200), 0.2), unit=1e-3))
    part = Intrinsics(475.0, 475.0, 100.0, 110.0, 200, 100)
    with pytest.raises(InvalidInput, match="shape"):
        without_pattern(frame(np.full((100, 200), 0.2), intrinsics=part), view.pattern(GAUGE))


@pytest.mark.parametrize("given", [{"plane_distance": None}, {}])
def test_no_pattern_comes_of_frames_that_tell_none(given):
    view = FreeView()
    view.add(frame(np.full((220, 200), 0.2) if given else np.zeros((220, 200)), **given))
    view.settle()
    assert view.pattern(GAUGE) is None
