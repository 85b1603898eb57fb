"""The next press: past the drop, within the limits, and never softer than the last."""

from dataclasses import replace

from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from stretch_bt.errors import IllConditioned
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


def test_a_press_stays_within_what_the_model_knows():
    known = replace(MODEL, range=Range(radius=(0.01, 0.06), stretch=(0.0, 0.08), depth=(0.0, 0.0112)))
    law = spring(1100.0)
    readings = [TopReading(x, TOP - depth, height(law, x, TOP - depth), 5e-6) for x, depth in TOUCHES]
    fit = fit_series(known, RADIUS, readings)
    plan = next_press(known, RADIUS.value, fit, readings[-1], 1.5e-3, LIMITS)
    assert plan.stretch > 0
    assert height(law, plan.stretch, plan.hand) - plan.hand <= 0.0112 - 3e-4
