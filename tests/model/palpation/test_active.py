"""The next look: within the limits, never softer, worth as much as it states, and none where none is worth its time."""

from dataclasses import replace

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from stretch_bt.errors import IllConditioned
from stretch_bt.model import Costs, ForceModel, Limits, Looks, TopReading, fit_series, next_look, next_press
from stretch_bt.units import Estimate

MODEL = ForceModel.default()
RADIUS = Estimate(0.03, 0.0)
TOP = 0.06
DROP = 1.5e-3
LIMITS = Limits(lowest=TOP - 0.018, force=8.0, stretch=0.08, stretch_step=0.01)
COSTS = Costs()
LOOKS = Looks(frame=3e-4, fixed=3e-5, robot=5e-5)
TOUCHES = [(0.0, 0.002), (0.0, 0.004), (0.0, 0.010)]


def law(stiffness, drop):
    """Return the force of an object whose force over drop is `stiffness`, N/m, at 1.5 mm."""
    return stiffness * DROP * (max(drop, 0.0) / DROP) ** 1.4


def height(stiffness, stretch, hand):
    """Return the height of the top at which membrane and object carry the same force."""
    return brentq(
        lambda h: MODEL.predict(RADIUS.value, stretch, max(h - hand, 0.0))[0] - law(stiffness, TOP - h),
        max(hand, TOP - 0.02),
        TOP,
    )


def pressed(stiffness, sd=3e-5, poses=TOUCHES):
    return [TopReading(x, TOP - depth, height(stiffness, x, TOP - depth), sd) for x, depth in poses]


def chosen(stiffness, *, sd=3e-5, poses=TOUCHES, limits=LIMITS, looks=LOOKS, costs=COSTS, **more):
    """Return the fit of exact readings and the look after them."""
    readings = pressed(stiffness, sd, poses)
    fit = fit_series(MODEL, RADIUS, readings)
    return fit, next_look(MODEL, RADIUS.value, fit, readings[-1], DROP, limits, looks, costs, **more)


@settings(max_examples=40, deadline=None)
@given(stiffness=st.floats(300.0, 3000.0), sd=st.floats(2e-6, 2e-4), at_press=st.booleans(), most=st.floats(1.5, 8.0))
def test_the_force_never_falls_and_the_limits_hold(stiffness, sd, at_press, most):
    limits = replace(LIMITS, force=most, stretch=0.04)
    try:
        fit, choice = chosen(stiffness, sd=sd, limits=limits, at_press=at_press, looks=replace(LOOKS, taken=200.0))
    except IllConditioned:
        assume(False)
    if choice is None:
        return
    assert choice.gain > 0.01
    assert choice.count in (8, 16, 32, 64)
    if choice.press is None:
        return
    now = law(stiffness, TOP - height(stiffness, 0.0, TOP - 0.010))
    then = law(stiffness, TOP - height(stiffness, choice.press.stretch, choice.press.hand))
    assert then > now
    assert fit.force.value < choice.press.force <= limits.force
    assert choice.press.hand >= limits.lowest
    assert 0.0 <= choice.press.stretch <= limits.stretch


@pytest.mark.parametrize("at_press", [False, True])
def test_a_look_leaves_the_deviation_that_it_says(at_press):
    readings = pressed(600.0, 8e-5)
    fit = fit_series(MODEL, RADIUS, readings)
    limits = replace(LIMITS, stretch=0.0)
    choice = next_look(
        MODEL, RADIUS.value, fit, readings[-1], DROP, limits, replace(LOOKS, taken=1e4), counts=[64], at_press=at_press
    )
    hand = choice.press.hand
    seen = TopReading(0.0, hand, height(600.0, 0.0, hand), (LOOKS.fixed**2 + LOOKS.frame**2 / 64) ** 0.5)
    after = fit_series(MODEL, RADIUS, [*readings, seen])
    told = after.stiffness() if at_press else after.stiffness_at(DROP)
    assert choice.relative_sd == pytest.approx(told.sd / told.value, rel=0.01)
    before = fit.stiffness() if at_press else fit.stiffness_at(DROP)
    assert choice.relative_sd < 0.95 * before.sd / before.value
    fall = 1 - (choice.relative_sd * before.value / before.sd) ** 2
    assert choice.gain * choice.seconds == pytest.approx(fall, rel=0.2)


def test_staying_is_worth_less_the_longer_the_press_was_looked_at():
    here = replace(LIMITS, lowest=TOP - 0.0101, stretch=0.0)
    gains = []
    for taken in (8.0, 32.0, 128.0):
        _, choice = chosen(600.0, sd=1e-4, limits=here, looks=replace(LOOKS, taken=taken), least=0.0)
        assert choice.press is None
        gains.append(choice.gain)
    assert gains[0] > 1.3 * gains[1] > 3 * gains[2] > 0


def test_a_press_that_takes_long_to_reach_is_looked_at_longer():
    looks = replace(LOOKS, taken=1e4)
    near = chosen(600.0, sd=1e-4, looks=looks)[1]
    far = chosen(600.0, sd=1e-4, looks=looks, costs=Costs(settle=10.0), least=0.0)[1]
    assert near.press is not None
    assert far.press is not None
    assert far.count > near.count


def test_while_the_drop_is_not_told_the_next_press_is_the_planned_one():
    readings = pressed(20000.0, 1e-4)
    fit = fit_series(MODEL, RADIUS, readings)
    choice = next_look(MODEL, RADIUS.value, fit, readings[-1], DROP, LIMITS, LOOKS)
    assert choice.press == next_press(MODEL, RADIUS.value, fit, readings[-1], DROP, LIMITS)
    assert (choice.count, choice.gain) == (16, pytest.approx(1 / choice.seconds))
