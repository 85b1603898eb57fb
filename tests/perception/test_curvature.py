import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.perception import brand, curvatures, deproject, to_membrane

RADIUS = 25e-3


def sphere_in_membrane_frame(pitch):
    n = int(0.6 * RADIUS / pitch)
    x, y = np.meshgrid(np.arange(-n, n + 1) * pitch, np.arange(-n, n + 1) * pitch)
    z = np.sqrt(RADIUS**2 - x * x - y * y)
    normals = np.stack([x, y, z], axis=-1) / RADIUS
    return np.stack([x, y, z - 0.8 * RADIUS], axis=-1), normals


@pytest.mark.parametrize("stride", [1, 3])
def test_brand_is_the_published_product_and_convex_is_positive(stride):
    points, normals = sphere_in_membrane_frame(0.5e-3)
    k_i, k_j = brand(points, normals, stride=stride)
    v, u = 12, 20
    expected = (points[v, u + stride] - points[v, u - stride]) @ (normals[v, u + stride] - normals[v, u - stride])
    assert k_i[v, u] == pytest.approx(expected)
    middle = points.shape[0] // 2
    near = (2 * stride * 0.5e-3) ** 2 / RADIUS
    assert k_i[middle, middle] == pytest.approx(near, rel=0.02)
    assert k_j[middle, middle] == pytest.approx(near, rel=0.02)
    assert np.isnan(k_i[:, :stride]).all()
    assert np.isfinite(k_i[:, stride:-stride]).all()


@pytest.mark.parametrize("pitch", [0.3e-3, 0.5e-3, 0.8e-3])
def test_curvature_of_a_sphere_is_one_over_its_radius_at_any_pitch(pitch):
    points, _ = sphere_in_membrane_frame(pitch)
    found = curvatures(points, np.ones(points.shape[:2], dtype=bool))
    middle = np.s_[points.shape[0] // 3 : -points.shape[0] // 3]
    for signal, expected in ((found.i, 1), (found.j, 1), (found.sum, 2)):
        np.testing.assert_allclose(signal[middle, middle], expected / RADIUS, rtol=0.02)


def test_mean_curvature_vanishes_on_a_tense_skirt_and_the_single_ones_do_not(surfaces):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.sphere_press(15e-3, np.radians(20)), lens)
    r = surfaces.distance_from_axis(depth, lens)
    points, valid = deproject(depth, lens)
    found = curvatures(to_membrane(points, surfaces.PLANE_DISTANCE), valid)
    skirt = found.trusted & (r > 10e-3) & (r < 25e-3)
    cap = r < 3e-3
    assert np.abs(found.sum[skirt]).max() < 0.05 * np.median(found.sum[cap])
    assert np.maximum(found.i, found.j)[skirt].max() > 0.1 * np.median(found.i[cap])


def test_a_tilted_plane_seen_in_perspective_has_no_curvature(surfaces):
    lens = surfaces.camera()
    u = (np.arange(lens.width) - lens.cx) / lens.fx
    depth = np.broadcast_to(0.2 / (1 + 0.5 * u), (lens.height, lens.width)).copy()
    found = curvatures(*deproject(depth, lens))
    assert not found.trusted[:, :5].any()
    assert np.abs(found.sum[25:-25, 25:-25]).max() < 0.3


def test_nothing_valid_has_no_trusted_curvature():
    found = curvatures(np.full((6, 6, 3), np.nan), np.zeros((6, 6), dtype=bool))
    assert not found.trusted.any()
    assert not found.sum.any()


def test_bad_strides_and_shapes_are_refused():
    points, normals = sphere_in_membrane_frame(1e-3)
    with pytest.raises(InvalidInput, match="stride"):
        brand(points, normals, stride=0)
    with pytest.raises(InvalidInput, match="one shape"):
        brand(points, normals[:-1])
