import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.coupling import couple
from stretch_bt.simulation.solve import find_root

TRAVEL = 0.012


def hertz(factor, power=1.5):
    return lambda d: (factor * d**power, power * factor * d ** (power - 1) if d > 0 else 0.0)


@given(exponent=st.floats(-3, 3), power=st.sampled_from([1.0, 1.5, 2.0, 3.0]), travel=st.floats(1e-6, 0.03))
def test_series_equilibrium_at_every_stiffness_ratio(exponent, power, travel):
    """Object over membrane stiffness from 1e-3 to 1e3: at most 10 evaluations, and the forces agree."""
    membrane = hertz(1.0 / travel**power, power)
    compliance = travel / 10**exponent
    found = couple(membrane, compliance, travel)
    assert found.iterations <= 10
    assert found.depth + found.drop == pytest.approx(travel, rel=1e-9)
    assert found.drop == pytest.approx(compliance * membrane(found.depth)[0], rel=1e-9)
    assert found.force == pytest.approx(found.drop / compliance, rel=1e-12)


def test_a_linear_membrane_is_two_springs_in_series():
    found = couple(hertz(300.0, 1.0), 1 / 900, TRAVEL)
    assert found.force == pytest.approx(TRAVEL / (1 / 300 + 1 / 900))


def test_a_rigid_object_does_not_drop_and_no_travel_is_no_force():
    assert couple(hertz(1e3), 0.0, TRAVEL)[:2] == pytest.approx((TRAVEL, 0.0))
    assert couple(hertz(1e3), 1e-3, 0.0) == (0.0, 0.0, 0.0, 0)


@pytest.mark.parametrize(("compliance", "travel"), [(-1e-3, 0.01), (1e-3, -0.01), (math.nan, 0.01), (1e-3, math.nan)])
def test_bad_input(compliance, travel):
    with pytest.raises(InvalidInput):
        couple(hertz(1e3), compliance, travel)


def test_what_does_not_converge_is_said():
    with pytest.raises(NoEquilibrium, match="a case: no convergence"):
        find_root(lambda x: (math.nan, math.nan), 0.0, 1.0, 0.5, "a case")


def test_newton_is_kept_in_the_bracket():
    assert find_root(
        lambda x: (math.atan(0.3 - x), -1 / (1 + (0.3 - x) ** 2)), -100.0, 90.0, 90.0, ""
    ).x == pytest.approx(0.3)
