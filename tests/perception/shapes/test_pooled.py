from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.perception import Sphere, pooled_sphere


def sphere(radius, sd, top=0.01):
    center, curvature_sd = np.array([0.0, 0.0, top - radius]), sd / radius**2
    return Sphere(radius, sd, center, np.array([1e-4, 1e-4, np.hypot(sd, 5e-5)]), 1 / radius, curvature_sd)


@pytest.mark.parametrize("apart", [0.0, 1e-3, -1e-3])
def test_two_fits_that_agree_give_one_that_is_better_at_the_same_top(apart):
    before, now = sphere(0.030, 1e-3, top=0.012), sphere(0.030 + apart, 1e-3)
    both = pooled_sphere(before, now)
    assert both.radius == pytest.approx(0.030 + apart / 2, rel=0.01)
    assert both.radius_sd == pytest.approx(1e-3 / np.sqrt(2), rel=0.05)
    assert both.center[2] + both.radius == pytest.approx(0.01)
    assert both.center_sd[2] == pytest.approx(np.hypot(both.radius_sd, 5e-5))


def test_the_top_of_a_hollow_stays_below_its_centre():
    hollows = [
        replace(ball, center=np.array([0.0, 0.0, 0.01 + ball.radius]), curvature=-ball.curvature)
        for ball in (sphere(0.031, 1e-3), sphere(0.029, 1e-3))
    ]
    for before, now in (hollows, hollows[::-1]):
        both = pooled_sphere(before, now)
        assert both.center[2] - both.radius == pytest.approx(0.01)


def test_fits_that_disagree_say_so_and_one_of_a_hollow_counts_nothing():
    before, now = sphere(0.030, 5e-4), sphere(0.020, 2e-4)
    both = pooled_sphere(before, now)
    assert 0.020 < both.radius < 0.030
    assert both.curvature_sd > 0.9 * abs(before.curvature - now.curvature) * 0.2
    assert both.curvature_sd > 3 * now.curvature_sd
    hollow = replace(before, curvature=-before.curvature)
    assert pooled_sphere(hollow, now) is now


def test_a_curvature_without_an_error_has_no_weight():
    with pytest.raises(InvalidInput, match="standard deviation above 0"):
        pooled_sphere(replace(sphere(0.03, 1e-3), curvature_sd=0.0), sphere(0.03, 1e-3))
