"""The ratio of the tensions from second derivatives off contact."""

import numpy as np
import pytest

from stretch_bt.perception import classify, expected_ratio, tension_ratio
from stretch_bt.perception.tension import combine
from stretch_bt.units import Estimate


def skirt(ratio, noise, rng, count=900, touching=0.2, bent=20.0):
    """Second derivatives that obey the ratio, with the noise of one isotropic filter, and some places in contact."""
    along_j = rng.normal(0.0, bent, count)
    along_i = -ratio * along_j
    hit = rng.random(count) < touching
    along_i[hit], along_j[hit] = -60.0, -60.0
    common, own, other = rng.standard_normal((3, count)) * noise
    return along_i + (common + np.sqrt(2) * own) / np.sqrt(3), along_j + (common + np.sqrt(2) * other) / np.sqrt(3)


@pytest.mark.parametrize("ratio", [1.0, 4.0, 15.0])
@pytest.mark.parametrize("noise", [0.5, 4.0])
def test_the_ratio_is_found_within_its_deviation_though_part_is_in_contact(ratio, noise):
    found = [tension_ratio(*skirt(ratio, noise, np.random.default_rng(seed))) for seed in range(40)]
    errors = np.array([f.value / ratio - 1.0 for f in found])
    stated = np.mean([f.sd / f.value for f in found])
    assert abs(errors.mean()) < max(0.03, 0.5 * stated)
    assert 0.5 < stated / errors.std() < 2.0


def test_a_known_stretch_narrows_the_expectation_and_the_frame_overrules_it():
    wide, pulled = expected_ratio(None), expected_ratio(0.03)
    assert pulled.sd / pulled < 0.5 * wide.sd / wide
    assert expected_ratio(0.06) > pulled > expected_ratio(0.005)
    between = combine(pulled, Estimate(pulled * 1.2, pulled.sd))
    assert pulled < between < pulled * 1.2
    assert between.sd < pulled.sd
    assert combine(pulled, Estimate(1.0, 0.05)) == Estimate(1.0, 0.05)


@pytest.mark.parametrize("stretch", [None, 0.03])
def test_an_even_tension_is_recognised_in_a_frame(surfaces, stretch):
    from stretch_bt.perception import deproject

    lens = surfaces.camera()
    depth = surfaces.render(surfaces.sphere_press(20e-3, np.radians(35)), lens)
    points, valid = deproject(surfaces.noisy(depth, 0.2e-3, np.random.default_rng(0)), lens)
    assert classify(points, valid, stretch=stretch).ratio == pytest.approx(1.0, abs=0.2)
