import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import deproject, to_membrane, view_rays

SR300 = Intrinsics(475.965, 475.964, 321.29, 245.87, 640, 480, (0.14374, 0.04621, 0.00426, 0.00561, 0.10719))
PLAIN = Intrinsics(476.0, 470.0, 31.5, 20.5, 64, 42)


def librealsense(intrinsics, u, v, depth):
    """rs2_deproject_pixel_to_point for RS2_DISTORTION_INVERSE_BROWN_CONRADY, one pixel, as published."""
    c = intrinsics.distortion
    x = (u - intrinsics.cx) / intrinsics.fx
    y = (v - intrinsics.cy) / intrinsics.fy
    r2 = x * x + y * y
    f = 1 + c[0] * r2 + c[1] * r2 * r2 + c[4] * r2 * r2 * r2
    ux = x * f + 2 * c[2] * x * y + c[3] * (r2 + 2 * x * x)
    uy = y * f + 2 * c[3] * x * y + c[2] * (r2 + 2 * y * y)
    return depth * ux, depth * uy, depth


@given(st.integers(0, 639), st.integers(0, 479), st.floats(0.05, 8.0))
def test_agrees_with_librealsense(u, v, distance):
    depth = np.full((480, 640), distance)
    points, valid = deproject(depth, SR300)
    assert valid.all()
    np.testing.assert_allclose(points[v, u], librealsense(SR300, u, v, distance), rtol=1e-12)


def test_distortion_moves_a_point_70_mm_off_axis_by_the_known_millimetres():
    straight = Intrinsics(SR300.fx, SR300.fy, SR300.cx, SR300.cy, 640, 480)
    depth = np.full((480, 640), 0.2)
    u = round(SR300.cx + 0.07 / 0.2 * SR300.fx)
    moved = deproject(depth, SR300)[0][246, u, 0] - deproject(depth, straight)[0][246, u, 0]
    assert 1.2e-3 < moved < 2.2e-3


def test_a_crop_has_the_points_of_the_full_image():
    depth = np.random.default_rng(0).uniform(0.1, 0.3, (480, 640))
    full, _ = deproject(depth, SR300)
    crop, _ = deproject(depth[100:300, 50:400], SR300.cropped(100, 300, 50, 400))
    np.testing.assert_allclose(crop, full[100:300, 50:400], rtol=1e-12)


def test_axes_are_x_right_y_down_z_forward_and_the_membrane_frame_turns_z():
    points, _ = deproject(np.full((42, 64), 0.2), PLAIN)
    assert (np.diff(points[..., 0], axis=1) > 0).all()
    assert (np.diff(points[..., 1], axis=0) > 0).all()
    raised, _ = deproject(np.full((42, 64), 0.19), PLAIN)
    np.testing.assert_allclose(to_membrane(raised, 0.2)[..., 2], 0.01, atol=1e-12)
    np.testing.assert_array_equal(to_membrane(raised, 0.2)[..., :2], raised[..., :2])


def test_rays_lead_from_the_camera_to_the_point_in_either_frame():
    points, _ = deproject(np.full((42, 64), 0.2), PLAIN)
    in_camera = view_rays(points)
    in_membrane = view_rays(to_membrane(points, 0.25), (0.0, 0.0, 0.25))
    np.testing.assert_allclose(np.linalg.norm(in_camera, axis=-1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(in_membrane, in_camera * [1, 1, -1], atol=1e-12)


def test_zero_nan_infinite_and_negative_depths_are_invalid():
    depth = np.full((42, 64), 0.2)
    depth[0, :4] = [0.0, np.nan, np.inf, -0.2]
    points, valid = deproject(depth, PLAIN)
    assert (~valid).sum() == 4
    assert not valid[0, :4].any()
    assert np.isnan(points[~valid]).all()
    assert np.isfinite(points[valid]).all()


def test_a_frame_carries_its_unit_and_intrinsics():
    raw = np.full((42, 64), 1600, dtype=np.uint16)
    raw[3, 5] = 0
    frame = DepthFrame(raw, 0.125e-3, PLAIN, 0.0, 0)
    points, valid = deproject(frame)
    assert points.dtype == np.float32
    assert not valid[3, 5]
    np.testing.assert_allclose(points[valid][:, 2], 0.2, rtol=1e-6)


@pytest.mark.parametrize(
    ("depth", "said"),
    [
        (np.full((480, 640), 0.2), "42 rows by 64 columns"),
        (np.full(64, 0.2), "shape (h, w)"),
        (np.full((42, 64), 1600, dtype=np.uint16), "multiply counts by their unit"),
        (np.full((42, 64), 200.0), "another unit"),
        (np.full((42, 64), 0.0002), "another unit"),
    ],
)
def test_bad_images_are_refused_with_what_was_expected(depth, said):
    with pytest.raises(InvalidInput) as refused:
        deproject(depth, PLAIN)
    assert said in str(refused.value)


def test_an_array_needs_intrinsics():
    with pytest.raises(InvalidInput, match="intrinsics"):
        deproject(np.full((42, 64), 0.2))
