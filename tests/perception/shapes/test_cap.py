from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

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
from stretch_bt.perception.shapes.blocks_kernel import blocks_within
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


def test_a_sphere_under_noise_that_neighbours_share_is_stated_wide_or_refused(press):
    small = seen(Press(Sphere(0.02), 0.03, 0.010))
    for view, radius in ((press, RADIUS), (small, 0.01)):
        for seed in range(3):
            try:
                fit = fit_contact_sphere(contact_of(view, CORRELATED, seed))
            except IllConditioned:
                continue
            assert abs(fit.curvature - 1 / radius) < 4 * fit.curvature_sd
            assert fit.curvature_sd > 0.02 / radius


PIXEL = 0.42e-3


def over(kind, size, degrees):
    """Return how high a sheet of constant tension stands over a body of revolution, by the distance from its axis, m.

    A sphere or a cone that it leaves at an angle; a disc, from whose edge it falls at that angle.
    """
    angle = np.radians(degrees)
    rim = size * np.sin(angle) if kind == "sphere" else size
    neck = rim * np.sin(angle)

    def height(r):
        inside = {
            "sphere": np.sqrt(np.maximum(size**2 - r**2, 0.0)) - size * np.cos(angle),
            "face": np.zeros_like(r),
            "cone": (rim - r) * np.tan(angle),
        }[kind]
        return np.where(r < rim, inside, -neck * (np.arccosh(np.maximum(r, rim) / neck) - np.arccosh(rim / neck)))

    return height, rim


def contact_over(kind, size, degrees, noise, seed):
    """Return what is seen from straight above of a sheet over a body, its middle off the middle and leaning."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[0:200, 0:200]
    x, y = (u - 100) * PIXEL, (v - 100) * PIXEL
    height, rim = over(kind, size, degrees)
    away = np.hypot(x - 3e-3, y + 2e-3)
    error = noise.white * rng.standard_normal(x.shape)
    if noise.correlated:
        blurred = gaussian_filter(rng.standard_normal(x.shape), noise.kernel)
        error += noise.correlated * 2.0 * np.sqrt(np.pi) * noise.kernel * blurred
    surface = np.stack([x, y, height(away) + 0.01 * x + error], axis=-1).astype(np.float32)
    touching = away < 0.8 * rim
    points, shown = surface[touching], surface_noise(surface)
    rays = np.broadcast_to(np.float32([0.0, 0.0, -1.0]), points.shape)
    labels, sure = np.where(touching, 2, 1).astype(np.uint8), touching.astype(np.float32)
    return Contact(points, rays, labels, shown.sd, 0.0, None, 0.0, surface, sure, noise_area=shown.area)


WHITE_05, BOTH = Noise(white=0.5e-3), Noise(white=0.2e-3, correlated=0.2e-3, kernel=2.5)


@pytest.mark.parametrize("noise", [WHITE_03, *(pytest.param(n, marks=pytest.mark.slow) for n in (WHITE_05, BOTH))])
@pytest.mark.parametrize(("radius", "degrees"), [(14e-3, 30), (25e-3, 20), (10e-3, 40), (8e-3, 55), (35e-3, 25)])
def test_the_curvature_of_a_cap_is_within_its_deviation(radius, degrees, noise):
    for seed in range(2):
        fit = fit_contact_sphere(contact_over("sphere", radius, degrees, noise, seed))
        assert abs(fit.curvature - 1 / radius) < 4 * fit.curvature_sd
        assert fit.curvature_sd < 0.15 / radius


@pytest.mark.parametrize("noise", [*(pytest.param(n, marks=pytest.mark.slow) for n in (WHITE_03, WHITE_05)), BOTH])
@pytest.mark.parametrize(
    ("kind", "size", "degrees", "reason"),
    [
        ("face", 6e-3, 25, "no radius"),
        ("face", 12e-3, 15, "no radius"),
        ("cone", 8e-3, 35, "cone"),
        ("cone", 12e-3, 25, "cone"),
    ],
)
def test_neither_a_face_nor_a_cone_has_a_radius(kind, size, degrees, reason, noise):
    for seed in range(2):
        with pytest.raises(IllConditioned, match=reason):
            fit_contact_sphere(contact_over(kind, size, degrees, noise, seed))


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
    blocks = blocks_within(pixels, 0.0, 0.0, 0.03, 0.02, 700)
    assert blocks[:, 3].mean() > 8.0
    means = known.of_means(float(blocks[:, 3].mean()))
    assert blocks[:, 2].std() == pytest.approx(means.sd, rel=tolerance)
    assert means.area == pytest.approx(1.0 + (known.area - 1.0) / blocks[:, 3].mean())


def test_blocks_are_means_of_what_is_seen():
    v, u = np.mgrid[0:60, 0:80] * 1e-3
    surface = np.stack([u, v, 0.2 * u + 0.1 * v], axis=-1)
    surface[:, 40:43] = np.nan
    blocks = blocks_within(surface, 0.04, 0.03, 0.02, 0.01, 100)
    inside = np.hypot((u - 0.04) / 0.02, (v - 0.03) / 0.01) < 1.0
    seen = np.count_nonzero(inside & np.isfinite(surface[..., 2]))
    assert 0.85 * seen < blocks[:, 3].sum() <= seen
    assert blocks[:, 3].max() in (4, 9)
    np.testing.assert_allclose(blocks[:, 2], 0.2 * blocks[:, 0] + 0.1 * blocks[:, 1], atol=1e-12)
    assert len(blocks_within(surface, 1.0, 0.0, 0.02, 0.01, 100)) == 0
