"""The force of a lump by how far it is pressed: implicit, rising, and never past what it flows at."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.simulation.coupling import couple
from stretch_bt.simulation.dough.lump import cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.resistance import Resistance

EDGE = 0.025


@settings(max_examples=30, deadline=None)
@given(
    stress=st.floats(0, 9),
    ratio=st.floats(1, 1e3),
    travel=st.floats(0, 0.3),
    thickening=st.sampled_from([0.0, 1.0, 1e6]),
    step=st.floats(-3, 3),
)
def test_the_force_rises_with_the_drop(stress, ratio, travel, thickening, step):
    dough = Dough(10**stress, ratio * 10**stress, thickening)
    lump, _ = cube(EDGE).rolled((travel, 0.0), 1.0, Dough(5e3, 1e5))
    felt = Resistance(lump, dough, 0.19)
    forces = np.array([felt.force(drop, 10**step)[0] for drop in np.linspace(0, 1.2 * lump.height, 200)])
    assert np.isfinite(forces).all()
    assert (np.diff(forces) >= -1e-9 * forces[-1]).all()
    assert forces[0] <= 1e-6


def test_a_cube_on_its_face_flows_at_its_section():
    stress = 5e3
    felt = Resistance(cube(EDGE), Dough(stress, 1e5))
    force, _ = felt.force(5e-3)
    section = EDGE**3 / (EDGE - 5e-3)
    assert force == pytest.approx(1.2 * stress * section, rel=0.05)


def test_below_its_yield_a_press_comes_back():
    felt = Resistance(cube(EDGE), Dough(1e9, 1e5))
    force, slope = felt.force(1e-3)
    assert felt.plastic(1e-3) == pytest.approx(0, abs=1e-15)
    assert force == pytest.approx(2 * (1e5 / 0.75) * math.sqrt(EDGE**2 / math.pi) * 1e-3, rel=0.05)
    assert slope == pytest.approx(force / 1e-3, rel=0.1)


@pytest.mark.parametrize("step", [0.1, 1.9, 2.1, 10.0, 1e3])
def test_no_step_goes_past_what_slow_pressing_leaves(step):
    """`step` is in units of the time in which the hand's spring relaxes; an explicit update keeps its overshoot past 2."""
    spring, travel = 300.0, 8e-3
    lump = cube(EDGE)
    slow, viscous = (Dough(2e3, 1e6, thickening, power=1.0) for thickening in (0.0, 1e3))
    time = viscous.thickening * EDGE / spring  # roughly: thickening x section / height over the spring's stiffness
    felt = Resistance(lump, slow)
    end = couple(lambda d: (spring * d, spring), felt.force, travel)
    most, before = felt.plastic(end.drop), 0.0
    lasting = Resistance(lump, viscous)
    dt = step * time
    found = couple(lambda d: (spring * d, spring), lambda d: lasting.force(d, dt), travel)
    set_ = lasting.plastic(found.drop, dt)
    assert before <= set_ <= most * (1 + 1e-9)
    if step >= 1e3:
        assert set_ == pytest.approx(most, rel=0.05)


@pytest.mark.parametrize("exponent", np.linspace(-3, 3, 13))
@pytest.mark.parametrize("dough", [Dough(5e3, 1e5), Dough(5e3, 1e7), Dough(5e3, 1e5, 500.0), Dough(1e9, 1e5)])
def test_it_meets_a_membrane_of_any_stiffness(exponent, dough):
    stiffness = 10**exponent * 2.6e3
    felt = Resistance(cube(EDGE), dough, 0.19)
    for travel in (1e-4, 2e-3, 7e-3):
        found = couple(lambda d: (stiffness * d, stiffness), lambda d: felt.force(d, 0.1), travel)
        assert found.iterations <= 10
        assert found.force == pytest.approx(felt.force(found.drop, 0.1)[0], rel=1e-6)
        assert found.depth + found.drop == pytest.approx(travel, rel=1e-9)
