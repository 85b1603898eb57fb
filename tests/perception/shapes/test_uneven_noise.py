"""Noise that is larger in places is measured there; what is chance is not."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from stretch_bt.perception.shapes.uneven_noise import SIDE, relative_noise


def smooth(rng, shape, length):
    return 2 * np.sqrt(np.pi) * length * gaussian_filter(rng.standard_normal(shape), length)


def noise(rng, length):
    residuals = smooth(rng, (160, 200), length) if length else rng.standard_normal((160, 200))
    residuals[rng.random(residuals.shape) < 0.05] = np.nan
    return residuals


@pytest.mark.parametrize(("length", "area"), [(0.0, 1.0), (1.1, 15.0), (3.0, 113.0)])
def test_noise_that_is_larger_in_places_is_measured_there(length, area):
    rng = np.random.default_rng(0)
    true = np.where(np.arange(200) < 100, 0.5, 1.5)
    found = relative_noise(true * noise(rng, length), area)
    left, right = found[:, :10], found[:, -10:]
    assert np.median(right) / np.median(left) == pytest.approx(3.0, rel=0.25)


@pytest.mark.parametrize(("length", "area"), [(0.0, 1.0), (1.1, 15.0), (3.0, 113.0)])
def test_chance_makes_no_noise_uneven(length, area):
    for seed in range(5):
        found = relative_noise(noise(np.random.default_rng(seed), length), area)
        assert found is None or np.abs(np.log(found)).max() < 0.25


@pytest.mark.parametrize(
    "residuals", [np.zeros((90, 90)), np.full((90, 90), np.nan), np.ones((5, 3)), np.zeros((1, 1))]
)
def test_where_there_is_no_noise_or_hardly_a_pixel_none_is_uneven(residuals):
    assert relative_noise(residuals, 1.0) is None


def test_squares_beyond_the_last_whole_one_count_to_it():
    rng = np.random.default_rng(1)
    found = relative_noise(noise(rng, 0.0) * np.linspace(0.2, 2.0, 200), 1.0)
    assert found.shape == (160 // SIDE, 200 // SIDE)
