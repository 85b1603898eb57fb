from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.accuracy.perception.noise import CORRELATED, WHITE_03, Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, Press, seen
from stretch_bt.errors import IllConditioned
from stretch_bt.perception import (
    Contact,
    SurfaceNoise,
    deproject,
    find_contact,
    fit_contact_sphere,
    fit_sphere,
    surface_noise,
    to_membrane,
    view_rays,
)
from stretch_bt.perception.shapes.rim import Rim, find_rim
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
    with pytest.raises(IllConditioned, match="by the same amount"):
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
            assert "by the same amount" in error.reason or "no radius" in error.reason
        else:
            assert abs(fit.curvature - 1 / RADIUS) < 4 * fit.curvature_sd
            assert fit.curvature_sd > 0.05 / RADIUS
    small = seen(Press(Sphere(0.02), 0.03, 0.010))
    for seed in range(4):
        with pytest.raises(IllConditioned):
            fit_contact_sphere(contact_of(small, CORRELATED, seed))


def test_noise_taken_for_a_rim_leaves_the_contact_as_segmented(press, monkeypatch):
    contact = contact_of(press, WHITE_03, 0)
    monkeypatch.setattr("stretch_bt.perception.shapes.cap.find_rim", lambda _: Rim(4e-3, -3e-3, 1e-3, 1e-3))
    assert fit_contact_sphere(contact).radius == pytest.approx(RADIUS, rel=0.05)
    whole = 2.0 * contact.points[:, :2].std(axis=0)
    flat = replace(contact, surface=contact.surface * [1.0, 1.0, 1e-3])
    monkeypatch.setattr("stretch_bt.perception.shapes.cap.find_rim", lambda _: Rim(4e-3, -3e-3, *whole))
    with pytest.raises(IllConditioned):
        fit_contact_sphere(flat)


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


def test_a_surface_without_neighbours_tells_nothing_of_its_noise():
    assert surface_noise(np.full((100, 100, 3), np.nan)) is None
    v, u = np.mgrid[0:100, 0:100] * 0.4e-3
    assert surface_noise(np.stack([u, v, 0.0 * u], axis=-1)) == SurfaceNoise(0.0, 1.0)


@pytest.mark.parametrize(
    "noise", [Noise(white=0.3e-3, dropouts=0.0), Noise(correlated=0.3e-3, kernel=2.0, dropouts=0.0)]
)
def test_a_contact_hands_on_the_noise_of_its_frame(press, noise):
    contact = find_contact(observe(press, noise, 0))
    alone = surface_noise(contact.surface)
    assert (contact.noise, contact.noise_area) == pytest.approx((alone.sd, alone.area), rel=0.01)


@pytest.mark.parametrize(
    ("noise", "tolerance"), [(Noise(white=0.3e-3), 0.1), (Noise(correlated=0.3e-3, kernel=2.0), 0.25)]
)
def test_the_noise_of_means_is_that_of_blocks(press, noise, tolerance):
    frames = (observe(press, noise, seed) for seed in (0, 1))
    first, second = (to_membrane(deproject(frame)[0], PLANE_DISTANCE) for frame in frames)
    apart = np.where(np.isfinite(first + second), (first - second)[..., 2:] / np.sqrt(2.0), 0.0)
    pixels = np.concatenate([first[..., :2], apart], axis=-1)
    known = surface_noise(first)
    rim = Rim(0.0, 0.0, 0.03, 0.02)
    blocks = rim.blocks(pixels, 1.0, 700)
    assert blocks[:, 3].mean() > 8.0
    means = known.of_means(float(blocks[:, 3].mean()))
    assert blocks[:, 2].std() == pytest.approx(means.sd, rel=tolerance)
    assert means.area == pytest.approx(1.0 + (known.area - 1.0) / blocks[:, 3].mean())


def test_blocks_are_means_of_what_is_seen():
    v, u = np.mgrid[0:60, 0:80] * 1e-3
    surface = np.stack([u, v, 0.2 * u + 0.1 * v], axis=-1)
    surface[:, 40:43] = np.nan
    blocks = Rim(0.04, 0.03, 0.02, 0.01).blocks(surface, 1.0, 100)
    inside = np.hypot((u - 0.04) / 0.02, (v - 0.03) / 0.01) < 1.0
    seen = np.count_nonzero(inside & np.isfinite(surface[..., 2]))
    assert 0.85 * seen < blocks[:, 3].sum() <= seen
    assert blocks[:, 3].max() in (4, 9)
    np.testing.assert_allclose(blocks[:, 2], 0.2 * blocks[:, 0] + 0.1 * blocks[:, 1], atol=1e-12)
    assert len(Rim(1.0, 0.0, 0.02, 0.01).blocks(surface, 1.0, 100)) == 0
