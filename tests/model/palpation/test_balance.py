"""The curve's derivatives, which readings are of one press, and the fit where the power stands at its bound."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.errors import IllConditioned
from stretch_bt.model import ForceModel, TopReading, fit_series
from stretch_bt.model.force.local import local_forces
from stretch_bt.model.palpation.balance import FLATTEST, SAME, STEEPEST, Balance, presses_of
from stretch_bt.units import Estimate

MODEL = ForceModel.default()
STIFFENING = Estimate(0.03, 0.06)
TOP = 0.06
DEPTHS = (0.002, 0.004, 0.007, 0.010, 0.010, 0.012)


def readings(stiffness, power, off):
    """Return readings of an object of so much force over drop at 1.5 mm, N/m, by bisection, each `off` by so much, m."""
    found = []
    for depth, error in zip(DEPTHS, off, strict=True):
        hand, low, high = TOP - depth, TOP - depth, TOP
        for _ in range(50):
            middle = (low + high) / 2
            more = MODEL.predict(0.03, 0.0, middle - hand)[0] > stiffness * 1.5e-3 * ((TOP - middle) / 1.5e-3) ** power
            low, high = (low, middle) if more else (middle, high)
        found.append(TopReading(0.0, hand, low + error, 3e-5))
    return found


def balance(given_, power, robot=5e-5):
    return Balance(local_forces(MODEL, 0.03, given_), given_, None, power, STIFFENING, robot)


@settings(max_examples=30, deadline=None)
@given(stiffness=st.floats(150.0, 3000.0), power=st.floats(0.8, 2.2), seed=st.integers(0, 99))
def test_the_derivatives_of_the_curve_are_those_of_its_values(stiffness, power, seed):
    noise = np.random.default_rng(seed)
    fit = balance(readings(stiffness, power, 3e-5 * noise.standard_normal(len(DEPTHS))), Estimate(1.4, 0.3))
    fit.solve()
    q = fit.q + np.r_[1e-5, 2e-5, 0.05, 0.02, 3e-5 * noise.standard_normal(len(fit.q) - 4)]
    _, rows = fit.curve(q)
    for k, step in enumerate(np.r_[1e-7, 1e-7, 1e-4, 1e-4, np.full(len(q) - 4, 1e-7)]):
        moved = np.eye(len(q))[k] * step
        slope = (fit.curve(q + moved)[0] - fit.curve(q - moved)[0]) / (2 * step)
        np.testing.assert_allclose(rows[:, k], slope, atol=1e-5 * max(1e-3, np.abs(slope).max()))


@pytest.mark.parametrize(
    ("poses", "presses"),
    [
        ([(0.0, 0.05)], [0]),
        ([(0.0, 0.05), (0.0, 0.05 + 0.9 * SAME), (0.0, 0.05)], [0, 0, 0]),
        ([(0.0, 0.05), (0.0, 0.05 + 1.1 * SAME), (0.0, 0.05)], [0, 1, 2]),
        ([(0.0, 0.05), (0.01, 0.05), (0.01, 0.05)], [0, 1, 1]),
        ([(0.0, 0.05 + 0.6 * SAME * i) for i in range(5)], [0, 0, 1, 1, 2]),
    ],
)
def test_another_press_begins_where_the_hand_is_not_where_it_was_at_its_first_look(poses, presses):
    assert presses_of([TopReading(x, hand, hand + 0.01, 1e-4) for x, hand in poses]).tolist() == presses


@pytest.mark.parametrize(("power", "bound"), [(0.3, FLATTEST), (12.0, STEEPEST)])
def test_at_a_bound_of_the_power_the_rest_is_fitted_to_that(power, bound):
    given_ = readings(600.0, power, np.zeros(len(DEPTHS)))
    fit = balance(given_, Estimate(bound, 20.0), robot=0.0)
    fit.solve()
    assert fit.q[2] == bound
    held = balance(given_, Estimate(bound, 1e-6), robot=0.0)
    held.solve()
    np.testing.assert_allclose(fit.q[:2], held.q[:2], atol=1e-7)


@pytest.mark.parametrize(
    ("heights", "top", "said"),
    [
        ([(TOP, TOP - 0.002), (TOP, TOP - 0.01), (TOP, TOP + 1e-3)], None, "not past the undeformed top"),
        ([(TOP, TOP + 1e-3), (TOP, TOP + 2e-3)], Estimate(TOP, 1e-5), "do not tell"),
    ],
)
def test_a_hand_above_the_top_tells_no_drop(heights, top, said):
    above = [TopReading(0.0, hand, height, 3e-5) for height, hand in heights]
    with pytest.raises(IllConditioned, match=said):
        fit_series(MODEL, Estimate(0.03, 0.0), above, top=top)


@pytest.mark.parametrize("robot", [0.0, 1e-300, 1e-12, 1e-9])
def test_a_hand_that_hardly_stands_off_is_one_that_does_not(robot):
    given_ = readings(600.0, 1.4, np.array([1, -2, 1, 2, -1, 1]) * 2e-5)
    found, exact = (fit_series(MODEL, Estimate(0.03, 0.0), given_, robot_sd=sd) for sd in (robot, 0.0))
    assert found.secant.sd == pytest.approx(exact.secant.sd, rel=1e-6)
    assert found.secant.value == pytest.approx(exact.secant.value, rel=1e-6)
