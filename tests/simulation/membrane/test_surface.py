import numpy as np
import pytest
from hypothesis import given

from stretch_bt.hardcases.domains.membrane.guards import FORMS, SPAN
from stretch_bt.hardcases.strategies.membrane import DEPTHS
from stretch_bt.simulation.membrane.surface import pressed_surface
from stretch_bt.simulation.objects.base import HertzForm


@pytest.mark.parametrize("name", FORMS)
@given(depth=DEPTHS)
def test_the_surface_meets_the_object_and_the_border(name, depth):
    surface = pressed_surface(FORMS[name], depth, SPAN)
    assert surface.height(0.0) == pytest.approx(depth, rel=1e-12)
    assert surface.height(SPAN * (1 - 1e-12)) == pytest.approx(0.0, abs=1e-9)
    assert surface.height(2 * SPAN) == 0.0
    profile = surface.height(np.linspace(0, SPAN, 400))
    assert np.all(np.diff(profile) <= 1e-12)


@pytest.mark.parametrize("depth", [0.002, 0.005, 0.010, 0.015])
def test_the_skirt_of_a_sphere_has_no_mean_curvature_and_no_kink(depth):
    surface = pressed_surface(FORMS["large sphere"], depth, SPAN)
    step = 1e-6
    a = surface.edge
    slopes = [(surface.height(r + step) - surface.height(r)) / step for r in (a - 2 * step, a + step)]
    assert slopes[1] == pytest.approx(slopes[0], rel=1e-3)
    r = np.linspace(1.1 * a, 0.95 * SPAN, 50)
    step = 1e-5
    slope = (surface.height(r + step) - surface.height(r - step)) / (2 * step)
    bend = (surface.height(r + step) - 2 * surface.height(r) + surface.height(r - step)) / step**2
    mean = bend / (1 + slope**2) + slope / r
    assert np.max(np.abs(mean)) < 1e-3 / 0.03


def test_a_plane_is_flat_all_over():
    surface = pressed_surface(HertzForm("plane", 0.04), 0.003, SPAN)
    np.testing.assert_array_equal(surface.height([0.0, 0.02, 0.1]), 0.003)
