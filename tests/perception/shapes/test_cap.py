from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.accuracy.perception.noise import CORRELATED, WHITE_03, Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, Press, seen
from stretch_bt.errors import IllConditioned
from stretch_bt.perception import Contact, deproject, fit_contact_sphere, fit_sphere, surface_noise, to_membrane, view_rays
from stretch_bt.perception.shapes.rim import find_rim
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

RADIUS = 15e-3


@pytest.fixture(scope="module")
def press():
    return seen(Press(Sphere(2 * RADIUS), 0.03, 0.018, (4e-3, -3e-3)))


def contact_of(view, noise, seed, *, long=1.0, wide=1.0):
    """Return an ellipse about the true contact, `long` times its size along i and `wide` times along j, as a contact."""
    frame = observe(view, noise, seed)
    points, valid = deproject(frame)
    points = to_membrane(points, PLANE_DISTANCE)
    true = points[view.touching & valid, :2]
    scale = 2.0 * true.std(axis=0) * [long, wide]
    with np.errstate(invalid="ignore"):
        mask = valid & (np.linalg.norm((points[..., :2] - true.mean(axis=0)) / scale, axis=-1) < 1.0)
    points[~valid] = np.nan
    labels = np.where(mask, 2, np.where(valid, 1, 255)).astype(np.uint8)
    rays = view_rays(points[mask], (0.0, 0.0, PLANE_DISTANCE))
    shown = surface_noise(points)
    sure = mask.astype(np.float32)
    return Contact(points[mask], rays, labels, shown.sd, 0.0, 0.03, 0.0, points, sure, noise_area=shown.area)


@pytest.mark.parametrize(("long", "wide"), [(1.0, 1.0), (1.3, 1.0), (2.0, 2.0), (0.6, 0.8), (0.5, 1.0)])
def test_the_sphere_is_found_from_a_poor_start(press, long, wide):
    fits = [fit_contact_sphere(contact_of(press, WHITE_03, seed, long=long, wide=wide)) for seed in range(3)]
    for fit in fits:
        assert fit.radius == pytest.approx(RADIUS, rel=0.03)
        assert abs(fit.curvature - 1 / RADIUS) < 4 * fit.curvature_sd
        np.testing.assert_allclose(fit.center[:2], [4e-3, -3e-3], atol=0.5e-3)
    touching = fit_sphere(contact_of(press, WHITE_03, 0).points)
    assert np.mean([f.curvature_sd for f in fits]) < 2.5 * touching.curvature_sd


def test_the_segmented_contact_alone_would_not_do(press):
    wide = contact_of(press, WHITE_03, 0, long=1.6, wide=2.0)
    with pytest.raises(IllConditioned, match="alike"):
        fit_sphere(wide.points, rays=wide.rays, noise=wide.noise)
    assert fit_contact_sphere(wide).radius == pytest.approx(RADIUS, rel=0.03)


def test_the_rim_is_that_of_the_contact(press):
    points, _ = deproject(press.depth, observe(press, WHITE_03, 0).intrinsics)
    true = to_membrane(points, PLANE_DISTANCE)[press.touching, :2]
    rim = find_rim(contact_of(press, WHITE_03, 1, long=1.3, wide=1.2))
    np.testing.assert_allclose([rim.a, rim.b], 2.0 * true.std(axis=0), rtol=0.12)
    np.testing.assert_allclose([rim.x, rim.y], true.mean(axis=0), atol=0.6e-3)


def test_a_sphere_under_noise_that_neighbours_share_is_refused(press):
    for seed in range(4):
        try:
            fit = fit_contact_sphere(contact_of(press, CORRELATED, seed))
        except IllConditioned as error:
            assert "alike" in error.reason or "no radius" in error.reason
        else:
            assert abs(fit.curvature - 1 / RADIUS) < 4 * fit.curvature_sd
            assert fit.curvature_sd > 0.05 / RADIUS
    small = seen(Press(Sphere(0.02), 0.03, 0.010))
    for seed in range(4):
        with pytest.raises(IllConditioned):
            fit_contact_sphere(contact_of(small, CORRELATED, seed))


def test_a_dent_is_no_contact(press):
    contact = contact_of(press, WHITE_03, 0)
    over = contact.surface * [1.0, 1.0, -1.0]
    with pytest.raises(IllConditioned, match="concave"):
        fit_contact_sphere(replace(contact, points=contact.points * [1.0, 1.0, -1.0], surface=over))


def test_a_flat_face_is_no_sphere():
    view = seen(Press(Cylinder(0.02), 0.03, 0.008, (0.004, -0.006)))
    with pytest.raises(IllConditioned):
        fit_contact_sphere(contact_of(view, WHITE_03, 0, long=0.8, wide=0.8))


@pytest.mark.parametrize(
    ("noise", "sd", "area"),
    [
        (Noise(white=0.3e-3), 0.3e-3, (1.0, 1.0)),
        (Noise(white=1e-3), 1e-3, (1.0, 1.0)),
        (Noise(correlated=1e-3), 1e-3, (70.0, 150.0)),
        (Noise(correlated=0.3e-3, kernel=1.2), 0.3e-3, (12.0, 24.0)),
    ],
)
def test_the_noise_of_a_surface_and_over_how_many_pixels_it_is_alike(press, noise, sd, area):
    found = [surface_noise(contact_of(press, noise, seed).surface) for seed in range(3)]
    assert np.mean([f.sd for f in found]) == pytest.approx(sd, rel=0.12)
    assert area[0] <= np.mean([f.area for f in found]) <= area[1]


def test_a_surface_smaller_than_a_tile_tells_nothing_of_its_noise():
    assert surface_noise(np.zeros((40, 200, 3))) is None
    assert surface_noise(np.full((100, 100, 3), np.nan)) is None
    assert surface_noise(np.zeros((100, 100, 3))).sd == 0.0
