import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.hardcases.strategies.coupling import FORCES
from stretch_bt.simulation.objects.buckling import BucklingResponse, plate_buckling_force
from stretch_bt.simulation.objects.paper_box import PaperBox
from stretch_bt.simulation.objects.roof import RoofOnWalls, RoofResponse

FALLING = BucklingResponse(1e4, 1.0, fall=0.4, over=5e-4)
RISING = BucklingResponse(1e4, 1.0)


@pytest.mark.parametrize(("modulus", "width", "low", "high"), [(2e9, 0.04, 0.70, 0.74), (5e9, 0.04, 1.76, 1.84)])
def test_paper_walls_buckle_at_the_force_of_plates(modulus, width, low, high):
    bending = modulus * 1e-4**3 / (12 * (1 - 0.3**2))
    assert low < plate_buckling_force(bending, width, 4) < high


@given(drop=st.floats(0, 5e-3))
def test_the_force_is_continuous_and_its_slope_is_its_derivative(drop):
    for walls in (RISING, FALLING):
        step = 1e-10
        below, above = walls.force(max(drop - step, 0.0))[0], walls.force(drop + step)[0]
        assert above - below == pytest.approx(0.0, abs=2 * step * 1.1e4)
        if min(abs(drop - kink) for kink in walls.kinks(None)) > 1e-8:
            assert (above - below) / (drop + step - max(drop - step, 0.0)) == pytest.approx(
                walls.force(drop)[1], rel=1e-3
            )


@given(force=st.floats(0, 20))
def test_the_drop_given_carries_the_force(force):
    for walls in (RISING, FALLING):
        assert walls.force(walls.given(force))[0] == pytest.approx(force, abs=1e-12)


def test_only_walls_whose_force_falls_have_a_memory():
    assert RISING.memory is None
    assert FALLING.memory == math.inf
    assert FALLING.drop(FALLING.after(FALLING.start(), 3e-4, 0.1)) == 3e-4


def box(**options):
    return PaperBox.model_validate(
        {"type": "paper_box", "length": "40 mm", "width": "40 mm", "height": "40 mm", **options}
    )


def test_a_bow_makes_walls_softer_and_leaves_the_force_at_which_they_buckle():
    flat, bowed = box(bow="0 mm").compliance(), box(bow="2 mm").compliance()
    assert flat.stiffness == pytest.approx(4 * 3e9 * 1e-4)
    assert bowed.stiffness < 0.01 * flat.stiffness
    assert bowed.critical == flat.critical


@pytest.mark.parametrize(("share", "low", "high"), [(0.25, 3e-4, 5e-4), (1.0, 5e-4, 8e-4)])
def test_the_roof_of_a_paper_box_sags_by_parts_of_a_millimetre_under_a_newton(share, low, high):
    assert low < box().roof(share).sag(1.0) < high


@given(force=st.floats(0, 50), linear=st.floats(1, 1e5), cubic=st.one_of(st.just(0.0), st.floats(1e3, 1e14)))
def test_the_sag_carries_the_force(force, linear, cubic):
    roof = RoofResponse(linear, cubic)
    assert roof.force(roof.sag(force))[0] == pytest.approx(force, rel=1e-6, abs=1e-12)


@given(force=FORCES)
def test_a_roof_and_its_walls_carry_the_same_force_and_add_up(force):
    roof, walls = box().roof(0.25), box().compliance()
    both = RoofOnWalls(roof, walls)
    drop = roof.sag(force) + walls.given(force)
    found, slope = both.force(drop)
    assert found == pytest.approx(force, rel=1e-9)
    step = 1e-6 * drop
    if abs(drop - both.kinks(None)[0]) > 2 * step:
        ahead, behind = both.force(drop + step)[0], both.force(drop - step)[0]
        assert slope == pytest.approx((ahead - behind) / (2 * step), rel=1e-3)
