import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.perception import deproject, estimate_normals, to_membrane
from stretch_bt.perception.surface import camera_side, clean, surface_of


@pytest.mark.parametrize("distance", [0.06, 0.2, 0.6])
@pytest.mark.parametrize("size", [(60, 80), (213, 333), (480, 640)])
def test_camera_and_membrane_frames_are_told_apart(surfaces, distance, size):
    points, valid = deproject(np.full(size, distance), surfaces.camera(*size))
    assert camera_side(points, valid) == -1
    assert camera_side(to_membrane(points, distance + 3e-3), valid) == 1


@pytest.mark.parametrize("noise", [0.2e-3, 1e-3])
def test_the_noise_of_a_pixel_is_measured(surfaces, noise):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.sphere_press(15e-3, 0.5), lens) + np.random.default_rng(0).normal(
        0, noise, (213, 333)
    )
    surface = surface_of(*deproject(depth, lens), kernel=1.9e-3)
    assert surface.noise == pytest.approx(noise, rel=0.1)


def test_flying_pixels_are_taken_out_and_the_steep_flank_stays(surfaces):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.disc_press(10e-3, 10e-3), lens)
    hit = np.random.default_rng(0).random(depth.shape) < 0.003
    surface = clean(*deproject(depth + 0.01 * hit, lens))
    assert not surface.valid[hit].any()
    assert surface.valid[~hit].mean() > 0.9999


def test_normals_face_the_camera_and_turn_with_the_frame(surfaces):
    lens = surfaces.camera()
    rng = np.random.default_rng(0)
    radius = 20e-3
    depth = surfaces.render(surfaces.sphere_press(radius, np.radians(40)), lens)
    r = surfaces.distance_from_axis(depth, lens)
    points, valid = deproject(surfaces.noisy(depth, 0.3e-3, rng), lens)
    in_camera, trusted = estimate_normals(points, valid)
    in_membrane, _ = estimate_normals(to_membrane(points, surfaces.PLANE_DISTANCE), valid)
    assert (in_camera[trusted][:, 2] < 0).all()
    np.testing.assert_allclose(in_membrane[trusted], in_camera[trusted] * [1, 1, -1], atol=1e-5)
    inside = trusted & (r < 0.5 * radius)
    exact = points[inside] * [1, 1, 0] / radius
    exact[:, 2] = np.sqrt(1 - (exact**2).sum(axis=1))
    angle = np.degrees(np.arccos(np.clip((in_membrane[inside] * exact).sum(axis=1), -1, 1)))
    assert np.sqrt((angle**2).mean()) < 1.5


@pytest.mark.parametrize("slopes", [(0.5, 0.5), (0.5, 0.0), (0.3, -0.4)])
def test_normals_of_a_plane_are_right_off_the_axis_of_the_camera(surfaces, slopes):
    lens = surfaces.camera(480, 640)
    u = (np.arange(640) - lens.cx) / lens.fx
    v = (np.arange(480)[:, None] - lens.cy) / lens.fy
    points, valid = deproject(0.2 / (1 - slopes[0] * u - slopes[1] * v), lens)
    found, trusted = estimate_normals(points, valid)
    exact = np.array([*slopes, -1.0]) / np.sqrt(1 + slopes[0] ** 2 + slopes[1] ** 2)
    angle = np.degrees(np.arccos(np.clip(found[trusted] @ exact, -1, 1)))
    assert np.quantile(angle, 0.9) < 0.5


def test_too_few_pixels_give_no_normals():
    points = np.full((5, 5, 3), np.nan)
    normals, trusted = estimate_normals(points, np.zeros((5, 5), dtype=bool))
    assert not trusted.any()
    assert normals.shape == (5, 5, 3)


@pytest.mark.parametrize(
    ("points", "valid"),
    [
        (np.zeros((4, 4)), np.ones((4, 4), dtype=bool)),
        (np.zeros((4, 4, 3)), np.ones((4, 5), dtype=bool)),
        (np.zeros((4, 4, 3)), np.ones((4, 4))),
        (np.zeros((4, 4, 3), dtype=int), np.ones((4, 4), dtype=bool)),
    ],
)
def test_bad_points_are_refused(points, valid):
    with pytest.raises(InvalidInput):
        estimate_normals(points, valid)
