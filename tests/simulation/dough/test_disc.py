"""A lump pressed to a disc: how thin, and how round."""

import math

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.perception import circularity
from stretch_bt.simulation.dough.disc import cracked, disc_force, outline, thickness
from stretch_bt.simulation.dough.lump import Lump, cube
from stretch_bt.simulation.dough.material import Dough

EDGE = 0.025
DOUGH = Dough(5e3)


def test_a_disc_of_25_mm_takes_the_force_that_it_should():
    """Y pi a^2 = 9.8 N for a radius of 25 mm, and 1.6 times that with friction 0.5 at a height of 8 mm."""
    assert disc_force(math.pi * 0.025**2 * 8e-3, 8e-3, DOUGH) == pytest.approx(9.82 * 1.6, rel=0.01)


@pytest.mark.parametrize("force", [1e-6, 0.3, 5.0, 1e3])
@pytest.mark.parametrize("friction", [0.0, 0.5, 1.0])
def test_thickness_is_where_the_force_is_borne(force, friction):
    dough = Dough(5e3, friction=friction)
    height = thickness(EDGE**3, force, dough)
    assert disc_force(EDGE**3, height, dough) == pytest.approx(force, rel=1e-9)


def test_the_outline_has_the_area_of_the_volume():
    found = outline(cube(EDGE), 8e-3, 720)
    x, y = found.T
    area = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2
    assert area == pytest.approx(EDGE**3 / 8e-3, rel=2e-3)


def test_a_ball_gets_a_round_outline_and_a_cube_a_square_one():
    ball = Lump(np.full(500, 0.0155), np.array([1.0, 0.0, 0.0, 0.0]), 4 / 3 * math.pi * 0.0155**3)
    assert float(circularity(outline(ball, 8e-3))) > 0.998
    assert float(circularity(outline(cube(EDGE), 8e-3))) == pytest.approx(0.85, abs=0.02)


def test_cracks_are_as_rough_and_as_long_as_asked():
    around = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    smooth = 0.025 * np.column_stack([np.cos(around), np.sin(around)])
    parts = np.array([np.hypot(*cracked(smooth, 0.015, 3e-3, seed).T) / 0.025 - 1 for seed in range(40)])
    assert parts.std() == pytest.approx(0.015, rel=0.1)
    lag = round(3e-3 / (2 * np.pi * 0.025) * 2000)
    assert np.mean(parts * np.roll(parts, lag, axis=1)) / parts.var() == pytest.approx(math.exp(-1), abs=0.1)
    assert np.array_equal(cracked(smooth, 0.015, 3e-3, 1), cracked(smooth, 0.015, 3e-3, 1))
    assert np.array_equal(cracked(smooth, 0.0, 3e-3, 1), smooth)


@pytest.mark.parametrize(
    "call",
    [
        lambda: thickness(EDGE**3, 0.0, DOUGH),
        lambda: thickness(math.nan, 1.0, DOUGH),
        lambda: outline(cube(EDGE), 0.0),
        lambda: cracked(np.zeros((4, 2)), -0.1, 1e-3),
    ],
)
def test_nonsense_is_refused(call):
    with pytest.raises(InvalidInput):
        call()
