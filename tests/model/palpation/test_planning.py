"""The next press: past the drop, within the limits, and never softer than the last."""

from dataclasses import replace

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model import ForceModel, Limits, TopReading, fit_series, next_press
from stretch_bt.model.force.force_model import Range
from stretch_bt.units import Estimate

MODEL = ForceModel.default()
RADIUS = Estimate(0.03, 0.0)
TOP = 0.06
LIMITS = Limits(lowest=TOP - 0.018, force=8.0, stretch=0.08, stretch_step=0.01)
TOUCHES = [(0.0, 0.002), (0.0, 0.004), (0.0, 0.010)]


def spring(stiffness):
    """Return the law of an object whose force over drop is `stiffness`, N/m, at 1.5 mm."""
    return lambda drop: stiffness * 1.5e-3 * (max(drop, 0.0) / 1.5e-3) ** 1.4


def height(law, stretch, hand):
    """Return the height of the top at which membrane and object carry the same force."""
    return brentq(
        lambda h: MODEL.predict(RADIUS.value, stretch, max(h - hand, 0.0))[0] - law(TOP - h), max(hand, TOP - 0.02), TOP
    )


def planned(stiffness, drop=1.5e-3, limits=LIMITS, sd=2e-5, poses=TOUCHES):
    law = spring(stiffness)
    readings = [TopReading(x, TOP - depth, height(law, x, TOP - depth), sd) for x, depth in poses]
    fit = fit_series(MODEL, RADIUS, readings)
    return fit, readings[-1], next_press(MODEL, RADIUS.value, fit, readings[-1], drop, limits)


@settings(max_examples=40, deadline=None)
@given(stiffness=st.floats(600.0, 3000.0), sd=st.floats(1e-6, 2e-4))
def test_the_force_never_falls_and_the_limits_hold(stiffness, sd):
    try:
        fit, last, plan = planned(stiffness, sd=sd)
    except IllConditioned:
        assume(False)
    law = spring(stiffness)
    now = law(TOP - height(law, last.stretch, last.hand))
    then = law(TOP - height(law, plan.stretch, plan.hand))
    assert then > now
    assert plan.force > fit.force.value
    assert plan.hand >= LIMITS.lowest
    assert plan.force <= LIMITS.force
    assert last.stretch <= plan.stretch <= LIMITS.stretch


@pytest.mark.parametrize("stiffness", [700.0, 1000.0, 1300.0])
def test_one_press_passes_the_drop_where_the_readings_are_good(stiffness):
    _, _, plan = planned(stiffness, sd=5e-6)
    law = spring(stiffness)
    dropped = TOP - height(law, plan.stretch, plan.hand)
    assert 1.5e-3 <= dropped < 1.9e-3
    assert plan.drop == pytest.approx(dropped, rel=0.05)


def test_a_membrane_too_slack_for_the_depth_is_stretched_at_once_as_far_as_it_takes():
    shallow = Limits(lowest=TOP - 0.011, force=8.0, stretch=0.08, stretch_step=0.01)
    _, _, plan = planned(1100.0, limits=shallow, sd=5e-6)
    assert plan.stretch >= 0.02
    assert plan.hand >= shallow.lowest


def test_a_press_stays_within_what_the_model_knows():
    known = replace(MODEL, range=Range(radius=(0.01, 0.06), stretch=(0.0, 0.08), depth=(0.0, 0.0112)))
    law = spring(1100.0)
    readings = [TopReading(x, TOP - depth, height(law, x, TOP - depth), 5e-6) for x, depth in TOUCHES]
    fit = fit_series(known, RADIUS, readings)
    plan = next_press(known, RADIUS.value, fit, readings[-1], 1.5e-3, LIMITS)
    assert plan.stretch > 0
    assert height(law, plan.stretch, plan.hand) - plan.hand <= 0.0112 - 3e-4


def test_what_was_felt_badly_is_not_overshot():
    """Readings too noisy for a forecast do not send the hand to where a soft object would be crushed."""
    sure = planned(2500.0, sd=5e-6)[2]
    unsure = planned(2500.0, sd=1.5e-4)[2]
    assert unsure.force < sure.force


def test_what_no_press_reaches_ends_in_the_hardest_and_then_in_a_refusal():
    limits = Limits(lowest=TOP - 0.012, force=8.0, stretch=0.02, stretch_step=0.01)
    fit, _, plan = planned(4000.0, limits=limits)
    assert (plan.stretch, plan.hand) == (0.02, pytest.approx(limits.lowest, abs=3e-4))
    assert plan.drop < 1.5e-3
    assert plan.force > fit.force.value
    with pytest.raises(IllConditioned, match="no press within the limits of depth, force and stretch is harder"):
        planned(4000.0, limits=limits, poses=[*TOUCHES, (0.02, 0.012)])


def test_an_object_that_never_deforms_is_refused_with_the_least_that_its_stiffness_is():
    limits = Limits(lowest=TOP - 0.010, force=8.0, stretch=0.0, stretch_step=0.01)
    with pytest.raises(IllConditioned, match=r"gave way by .* too little to tell; its stiffness is above about"):
        planned(1e7, limits=limits)


@pytest.mark.parametrize(
    "wrong",
    [(float("nan"), 8.0, 0.08, 0.01), (0.04, 0.0, 0.08, 0.01), (0.04, 8.0, -0.01, 0.01), (0.04, 8.0, 0.08, 0.0)],
)
def test_limits_that_are_none_are_refused(wrong):
    with pytest.raises(InvalidInput, match="limits"):
        Limits(*wrong)
