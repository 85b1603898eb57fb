"""An outline of none of the shapes is refused, or the deviation counts the misfit; outlines of a shape are measured as before."""

from functools import cache

import numpy as np
import pytest
from outline_kinds import CLEAN, WHITE_03, ellipse, measured, off, polygon, prism, rectangle

from stretch_bt.accuracy.perception.view import BodyPress
from stretch_bt.errors import IllConditioned
from stretch_bt.perception.size.measure import FILLET_SD
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

OUTLINES = {
    "hexagon": polygon(6, 10e-3),
    "heptagon": polygon(7, 10e-3),
    "turned ellipse": ellipse(20.1e-3, 16.1e-3, np.radians(40)),
    "very round rectangle": rectangle(22e-3, 14e-3, 6e-3),
}


@cache
def press(name):
    return BodyPress(prism(OUTLINES[name]), 25e-3, 10e-3)


@pytest.mark.parametrize("name", ["hexagon", "very round rectangle"])
def test_an_outline_that_is_clearly_none_is_refused(name):
    with pytest.raises(IllConditioned, match=r"neither a circle.*nor a rectangle.*name a shape"):
        measured(press(name), CLEAN, 0)


@pytest.mark.parametrize("name", ["hexagon", "heptagon", "turned ellipse"])
def test_an_outline_that_noise_may_hide_widens_the_deviation(name):
    for seed in range(2):
        size = measured(press(name), WHITE_03, seed)
        assert off(size, OUTLINES[name]) < 5.0


def test_a_circle_without_noise_is_a_circle_with_its_ordinary_deviation():
    size = measured(BodyPress(Cylinder(14.31e-3), 25e-3, 10e-3), CLEAN, 0)
    assert size.shape == "circle"
    assert abs(size.diameter_i - 14.31e-3) < 2 * size.diameter_i_sd < 0.4e-3


FEW = ((14e-3, 0.3e-3), (14e-3, 2e-3), (22e-3, 1e-3))
MORE = ((22e-3, 0.3e-3), (22e-3, 1.5e-3))


@pytest.mark.parametrize("edges", [FEW, pytest.param(FEW + MORE, marks=pytest.mark.slow)], ids=["few", "all"])
def test_an_edge_of_any_radius_to_2_mm_is_within_what_is_stated(edges):
    errors = []
    for diameter, rim in edges:
        size = measured(BodyPress(Cylinder(diameter, rim), 25e-3, 10e-3), WHITE_03, 0, FILLET_SD)
        errors.append((size.diameter_i - diameter) / size.diameter_i_sd)
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.3
