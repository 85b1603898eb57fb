from types import SimpleNamespace

import numpy as np
import pytest

from stretch_bt.accuracy.perception.noise import CORRELATED, Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, BodyPress, seen
from stretch_bt.errors import IllConditioned
from stretch_bt.hardcases.domains.fits.contacts import BALL, RADIUS, cut_out
from stretch_bt.perception import (
    SurfaceNoise,
    deproject,
    find_contact,
    fit_contact_sphere,
    surface_noise,
    to_membrane,
)
from stretch_bt.perception.shapes.blocks_kernel import blocks_within, fill_within
from stretch_bt.perception.shapes.cap import _sphere
from stretch_bt.simulation.membrane.indenters.sphere import Sphere


@pytest.fixture(scope="module")
def press():
    return seen(BALL)


def test_a_sphere_under_noise_that_neighbours_share_is_stated_wide_or_refused(press):
    small = seen(BodyPress(Sphere(0.02), 0.03, 0.010))
    for view, radius in ((press, RADIUS), (small, 0.01)):
        for seed in range(3):
            try:
                fit = fit_contact_sphere(cut_out(view, CORRELATED, seed))
            except IllConditioned:
                continue
            assert abs(fit.curvature - 1 / radius) < 4 * fit.curvature_sd
            assert fit.curvature_sd > 0.02 / radius


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
    found = [surface_noise(cut_out(press, noise, seed).surface) for seed in range(3)]
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
    # noise that a Gaussian made alike; the squares blur as a Gaussian of their own variance does
    pixels_each = float(blocks[:, 3].mean())
    alike = 1.0 + (known.area - 1.0) / pixels_each
    assert blocks[:, 2].std() == pytest.approx(known.sd * np.sqrt(known.area / (alike * pixels_each)), rel=tolerance)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_pixels_of_a_window_are_those_of_its_ellipse(dtype):
    surface = np.random.default_rng(0).normal(0.0, 0.03, (50, 70, 3)).astype(dtype)
    surface[4, 5:30] = np.nan
    found = np.empty((50, 70), dtype=bool)
    fill_within(surface, 0.01, -0.02, 0.03, 0.02, found)
    with np.errstate(invalid="ignore"):
        wanted = ((surface[..., 0] - 0.01) / 0.03) ** 2 + ((surface[..., 1] + 0.02) / 0.02) ** 2 < 1.0
    np.testing.assert_array_equal(found, wanted)


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


@pytest.mark.parametrize("sure", [1.0, 0.3, 0.01])
@pytest.mark.parametrize("alike", [0.99, -0.99])
def test_a_curvature_that_is_surer_than_the_fit_leaves_the_middle_its_deviation(sure, alike):
    """Beside a curvature of a fit that it does not have, the covariance was none: the middle was stated with 0."""
    covariance = 1e-4 * (np.eye(4) + alike * (np.eye(4)[[3, 1, 2, 0]] - np.diag([0, 1, 1, 0])))
    fit = SimpleNamespace(surface=SimpleNamespace(q=np.array([0.3, 0.2, 0.5, 0.8])), covariance=covariance)
    explained = SimpleNamespace(cells=SimpleNamespace(size=0.01, origin=np.zeros(3)), scale=1.0, wider=1.0)
    found = _sphere(fit, 0.8, 0.01 * sure, explained)
    assert found.center_sd.min() > 1e-5
