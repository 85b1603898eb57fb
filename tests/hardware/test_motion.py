"""Paths through poses, and how far along them a motion is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.behaviors._rolling import laid
from stretch_bt.frames import Pose
from stretch_bt.hardware.motion.path import PosePath
from stretch_bt.hardware.motion.profile import Profile

LENGTH = st.floats(1e-6, 1.0)
SPEED = st.floats(1e-3, 1.0)
ACCELERATION = st.floats(0.05, 10.0)


@given(length=LENGTH, speed=SPEED, acceleration=ACCELERATION, part=st.floats(0, 1.2))
def test_a_profile_keeps_its_speed_and_acceleration(length, speed, acceleration, part):
    profile = Profile.trapezoid(length, speed, acceleration)
    assert profile.at(profile.duration)[0] == pytest.approx(length)
    assert profile.at(profile.duration)[1] == 0.0
    times = np.linspace(0, 1.1 * profile.duration, 60)
    places = np.array([profile.at(t) for t in times])
    assert np.all(np.diff(places[:, 0]) >= -1e-12)
    assert np.all(places[:, 1] <= speed * (1 + 1e-9))
    assert np.all(np.abs(np.diff(places[:, 1])) <= acceleration * np.diff(times) * (1 + 1e-6) + 1e-12)
    time = part * profile.duration
    braked = profile.braked(time, acceleration)
    distance, moving = profile.at(time)
    assert braked.at(time)[0] == pytest.approx(distance)
    assert braked.at(1e9)[0] == pytest.approx(distance + moving**2 / (2 * acceleration))
    assert braked.at(1e9)[0] <= length * (1 + 1e-9)
    assert braked.at(time / 2) == profile.at(time / 2)


@given(length=LENGTH, speed=SPEED, acceleration=ACCELERATION, part=st.floats(0, 1))
def test_a_profile_knows_when_it_is_where(length, speed, acceleration, part):
    profile = Profile.trapezoid(length, speed, acceleration).braked(0.7 * length / speed, acceleration)
    time = profile.when(part * profile.length)
    assert 0.0 <= time <= profile.duration
    assert profile.at(time)[0] == pytest.approx(part * profile.length, abs=1e-9 * length)


def test_no_way_takes_no_time():
    assert Profile.trapezoid(0.0, 0.1, 1.0).duration == Profile.trapezoid(0.0, 0.1, 1.0).when(0.0) == 0.0


def test_a_path_turns_at_its_sharp_corners_and_along_a_lap_nowhere():
    lap = laid("circle", 0.01, Pose((0, 0, 0.1)), 0.0, 1.0, 60)
    assert PosePath(lap).corners == []
    down, up, aside = Pose((0, 0, 0.05)), Pose((0, 0, 0.08)), Pose((0.03, 0, 0.08))
    assert PosePath([Pose((0, 0, 0.1)), down, down, up, aside]).corners == pytest.approx([0.05, 0.08])
    assert PosePath([up, Pose(up.position, (0, 0, 0.1)), up]).corners == pytest.approx([0.01])


def test_a_path_goes_through_its_poses_and_ends_at_the_floor():
    path = PosePath([Pose((0, 0, 0.1)), Pose((0.1, 0, 0.1)), Pose((0.1, 0, -0.1), (0, 0, 0.3))])
    assert path.at(0.05).position == pytest.approx((0.05, 0, 0.1))
    assert path.at(0.2).rotation == pytest.approx((0, 0, 0.15))
    assert path.above(0.0).length == pytest.approx(0.2)
    assert path.above(0.0).at(9.0).position == pytest.approx((0.1, 0, 0.0))
    assert path.above(-0.2) is path
    assert PosePath([Pose((0, 0, 0.1)), Pose((0, 0, 0.1), (0, 0, 1))]).length == pytest.approx(0.1)


ANGLE = st.floats(-np.pi, np.pi)


@given(st.tuples(ANGLE, ANGLE, ANGLE), st.integers(-1, 1), st.floats(0.0, 1e-6))
def test_the_same_orientation_written_otherwise_is_no_turn(rotation, rounds, off):
    """As a measured rotation vector near half a turn is, whose sign noise decides."""
    angle = np.linalg.norm(rotation)
    other = np.multiply(rotation, 1 + rounds * 2 * np.pi / angle + off) if angle > 1e-6 else np.array(rotation)
    path = PosePath([Pose((0, 0, 0.1), rotation), Pose((0, 0, 0.2), tuple(other.tolist()))])
    assert path.length == pytest.approx(0.1)
    assert path.at(0.05).rotation == pytest.approx(rotation, abs=1e-4)
    assert path.at(0.1).matrix() == pytest.approx(Pose(rotation=tuple(other.tolist())).matrix(), abs=1e-9)


@given(st.tuples(ANGLE, ANGLE, ANGLE), st.tuples(ANGLE, ANGLE, ANGLE))
def test_no_turn_is_longer_than_half_a_round_about_the_axis_it_ends_at(one, other):
    path = PosePath([Pose(rotation=one), Pose(rotation=other)])
    last = np.array(path.poses[1].rotation)
    assert Pose(rotation=other).matrix() == pytest.approx(path.poses[1].matrix(), abs=1e-9)
    axis = last / (np.linalg.norm(last) or 1.0)
    assert abs(axis @ np.subtract(last, one)) <= np.pi * (1 + 1e-9)
