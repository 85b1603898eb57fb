from dataclasses import fields

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from stretch_bt.perception import fit_sphere
from stretch_bt.perception.shapes.correlation import correlation_area

SIDE = np.arange(60) * 0.42e-3
X, Y = (w.ravel() for w in np.meshgrid(SIDE, SIDE))


def alike(kernel, seed, shape=(60, 60)):
    smooth = gaussian_filter(np.random.default_rng(seed).standard_normal(shape), kernel, mode="wrap")
    return smooth / smooth.std()


@pytest.mark.parametrize("kernel", [1.0, 2.0, 3.0])
def test_the_area_of_gaussian_noise_is_that_of_its_correlation(kernel):
    found = [correlation_area(X, Y, alike(kernel, seed).ravel(), 4) for seed in range(20)]
    assert np.median(found) == pytest.approx(4 * np.pi * kernel**2, rel=0.35)


def test_white_noise_is_alike_over_one_point():
    found = [correlation_area(X, Y, alike(0.0, seed).ravel(), 4) for seed in range(50)]
    assert found.count(1.0) == 50


@pytest.mark.parametrize("seed", range(6))
def test_the_order_of_the_points_does_not_matter(seed):
    """The last of several points of one cell stood for all of them."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-12e-3, 12e-3, (2, 700))
    smooth = np.cos(900.0 * x + rng.uniform(0, 6)) * np.cos(900.0 * y) + 0.3 * rng.standard_normal(x.size)
    area = correlation_area(x, y, smooth, 4)
    points = np.column_stack([x, y, np.sqrt(0.02**2 - x**2 - y**2) + 0.1e-3 * smooth])
    sphere, order = fit_sphere(points), rng.permutation(x.size)
    assert area > 1.5
    assert correlation_area(x[order], y[order], smooth[order], 4) == pytest.approx(area, rel=1e-9)
    other = fit_sphere(points[order])
    assert other.radius_sd == pytest.approx(sphere.radius_sd, rel=1e-9)
    for field in fields(sphere):
        if field.name.endswith("_sd"):
            np.testing.assert_allclose(getattr(other, field.name), getattr(sphere, field.name), rtol=1e-6)


def test_a_sphere_states_the_deviation_that_noise_alike_gives_it():
    x, y = X - X.mean(), Y - Y.mean()
    inside = np.hypot(x, y) < 12e-3
    z = np.sqrt(0.02**2 - x[inside] ** 2 - y[inside] ** 2)
    fits = [
        fit_sphere(np.column_stack([x[inside], y[inside], z + 0.1e-3 * alike(2.0, seed).ravel()[inside]]))
        for seed in range(60)
    ]
    spread = np.std([f.curvature for f in fits])
    assert np.mean([f.curvature_sd for f in fits]) == pytest.approx(spread, rel=0.35)


def test_points_on_a_thin_strip_or_far_apart_cost_no_endless_grid():
    strip = np.linspace(0.0, 1.0, 500)
    assert correlation_area(strip, 1e-9 * (strip % 0.01), np.sin(40 * strip), 4) >= 1.0
    assert correlation_area(np.append(X, 1e6), np.append(Y, 1e6), np.append(alike(0.0, 1).ravel(), 0.0), 4) >= 1.0
