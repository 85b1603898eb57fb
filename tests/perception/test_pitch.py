import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import deproject, to_membrane
from stretch_bt.perception.hand_eye import view_of_hand
from stretch_bt.perception.pitch import check_square, pitch_of

H, W = 120, 160


def seen(ratio, slopes, noise, seed, parallel=False, window=np.s_[:, :]):
    """Points of a noisy slope by pixels `ratio` times as wide as high."""
    lens = Intrinsics(240.0, 240.0 * ratio, 75.0, 63.0, W, H)
    v, u = np.mgrid[:H, :W]
    across, down = (u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy
    depth = 0.2 / (1 - slopes[0] * across - slopes[1] * down)
    depth = depth + np.random.default_rng(seed).normal(0.0, noise, depth.shape)
    points, valid = deproject(depth, lens)
    if parallel:
        points = np.stack([0.2 * across, 0.2 * down, 0.2 - depth], axis=2)
    return to_membrane(points, 0.2)[window], valid[window]


@given(
    st.sampled_from([0.5, 0.9, 0.97, 0.985, 1.0, 1.015, 1.04, 2.0]),
    st.tuples(*[st.floats(-0.6, 0.6)] * 2),
    st.sampled_from([0.0, 2e-4, 5e-3]),
    st.integers(0, 9),
    st.booleans(),
    st.sampled_from([np.s_[:, :], np.s_[10:40, 120:150], np.s_[3:, ::1]]),
)
def test_pixels_are_square_or_refused_whatever_the_slope_and_the_noise(ratio, slopes, noise, seed, parallel, window):
    points, valid = seen(ratio, slopes, noise, seed, parallel, window)
    pitch = pitch_of(points, valid)
    if abs(ratio - 1) < 0.02:
        check_square(points, valid, pitch)
    else:
        with pytest.raises(InvalidInput, match="resample the depth image to square pixels"):
            check_square(points, valid, pitch)


@given(st.floats(0.0, 0.6), st.floats(0.0, 6.0), st.sampled_from([0.0, 2e-4]))
def test_points_by_square_pixels_that_were_turned_are_taken(tilt, towards, noise):
    points, valid = seen(1.0, (0.2, 0.1), noise, 0)
    c, s = np.cos(tilt), np.sin(tilt)
    a = np.array([np.cos(towards), np.sin(towards), 0.0])
    k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    turned = points @ (np.eye(3) + s * k + (1 - c) * k @ k).T
    check_square(turned, valid, pitch_of(turned, valid))


@pytest.mark.parametrize("shape", [(1, 40), (40, 1), (2, 2), (0, 0)])
def test_points_that_leave_the_shape_of_a_pixel_free_are_taken(shape):
    points, valid = np.zeros((*shape, 3)), np.ones(shape, bool)
    points[..., 1], points[..., 0] = (n * 1e-3 for n in np.indices(shape))
    check_square(points, valid, pitch_of(points, valid))


@pytest.mark.parametrize("lens", [(400, 200, 240, 130), (200, 400, 120, 260)])
def test_a_hand_is_as_long_by_pixels_that_are_not_square(lens):
    fx, fy, w, h = lens
    camera = Intrinsics(fx, fy, (w - 1) / 2 + 0.3, (h - 1) / 2 - 0.2, w, h)
    v, u = np.mgrid[:h, :w]
    x, y = (u - camera.cx) / fx * 0.2, (v - camera.cy) / fy * 0.2
    depth = np.where((abs(x) < 0.045) & (abs(y) < 0.05), 0.2, 0.35)
    found = view_of_hand(DepthFrame.from_array(depth, camera, unit=8e-6, plane_distance=0.2), 0.2)
    pixel = 0.2 / fy
    assert abs(found.length.value - 0.1) < pixel / 2
    assert found.length.sd == pytest.approx(pixel / np.sqrt(6), rel=0.2)
