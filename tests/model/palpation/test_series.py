"""A soft object in series with the membrane: its curve from heights of its top."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model import POWER, STIFFENING, ForceModel, TopReading, fit_series
from stretch_bt.units import Estimate

MODEL = ForceModel.default()
RADIUS = Estimate(0.03, 0.0)
TOP = 0.06
DROP = 1.5e-3
#: stretch and depth of the hand past first contact: a touch, then presses
POSES = [(0.0, 0.002), (0.0, 0.003), (0.0, 0.004), (0.0, 0.010), (0.02, 0.012)]


def height(law, stretch, hand):
    """Return the height of the top at which membrane and object carry the same force."""
    return brentq(
        lambda h: MODEL.predict(RADIUS.value, stretch, max(h - hand, 0.0))[0] - law(TOP - h),
        max(hand, TOP - 0.02),
        TOP,
        xtol=1e-14,
    )


def spring(stiffness, power):
    """Return the law of an object whose force over drop is `stiffness`, N/m, at 1.5 mm."""
    return lambda drop: stiffness * DROP * (max(drop, 0.0) / DROP) ** power


def skin(stiffness, power, stiffening):
    """Return the law of an object whose power grows by so much a millimetre of drop."""
    law = spring(stiffness, power)
    return lambda drop: law(drop) * math.exp(stiffening * (max(drop, 0.0) - DROP) / 1e-3)


def seen(law, sd=1e-6, noise=None, robot=0.0, poses=POSES):
    """Return readings by a camera on the hand, which stands off where it was sent by as much in all looks at one press."""
    readings, stands = [], 0.0
    for i, (stretch, depth) in enumerate(poses):
        hand = TOP - depth
        if i == 0 or poses[i - 1] != (stretch, depth):
            stands = hand + (robot * noise.standard_normal() if noise else 0.0)
        off = sd * noise.standard_normal() if noise else 0.0
        readings.append(TopReading(stretch, hand, hand + height(law, stretch, stands) - stands + off, sd))
    return readings


@settings(max_examples=15, deadline=None)
@given(stiffness=st.floats(80.0, 4000.0), power=st.floats(0.9, 2.2))
def test_exact_readings_give_the_exact_curve(stiffness, power):
    law = spring(stiffness, power)
    readings = seen(law, sd=1e-9)
    found = fit_series(
        MODEL, RADIUS, readings, power=Estimate(power + 0.1, 10.0), stiffening=Estimate(0.0, 1e-3), robot_sd=0.0
    )
    true = TOP - readings[-1].height
    assert found.power.value == pytest.approx(power, abs=2e-3)
    assert found.top.value == pytest.approx(TOP, abs=2e-7)
    assert found.drop.value == pytest.approx(true, rel=1e-3)
    assert found.secant.value == pytest.approx(law(true) / true, rel=1e-3)
    assert found.stiffness_at(DROP).value == pytest.approx(stiffness, rel=2e-3)


def test_a_factor_that_the_model_is_wrong_by_leaves_the_drops_and_scales_the_stiffness():
    law = spring(600.0, 1.4)
    right, wrong = (fit_series(Factored(f), RADIUS, seen(law, sd=1e-8), robot_sd=0.0) for f in (1.0, 0.8))
    assert wrong.drop.value == pytest.approx(right.drop.value, rel=1e-6)
    assert wrong.secant.value == pytest.approx(0.8 * right.secant.value, rel=1e-6)


class Factored:
    """The default model with its force times a factor, or falling with depth where the factor is negative."""

    def __init__(self, factor):
        self.factor, self.range = factor, MODEL.range

    def predict(self, radius, stretch, depth):
        force, sd = MODEL.predict(radius, stretch, depth)
        if self.factor < 0:
            return 1.0 - force, sd
        return self.factor * force, self.factor * sd


#: a ladder of touches, a press, and one that lowers the top by 3 mm: the readings tell the power
SPREAD = [(0.0, 1e-3 * depth) for depth in (2, 3, 4, 5, 6, 10)]


@pytest.mark.parametrize(
    ("name", "law"),
    [
        pytest.param("spring", skin(400.0, 1.0, 0.0), marks=pytest.mark.slow),
        pytest.param("elastic ball", skin(400.0, 1.5, 0.0), marks=pytest.mark.slow),
        ("filled skin", skin(400.0, 1.17, 0.15)),
    ],
)
def test_one_prior_serves_a_spring_a_ball_and_a_filled_skin(name, law):
    """Mean error below 3 %, and errors as large as stated, over 60 draws of noise and of the robot's place."""
    noise, errors, stated = np.random.default_rng(11), [], []
    last = (0.0, brentq(lambda depth: TOP - height(law, 0.0, TOP - depth) - 3.2e-3, 0.004, 0.024))
    true = TOP - height(law, *_at_hand(last))
    for _ in range(60):
        readings = seen(law, 3e-5, noise, robot=5e-5, poses=[*SPREAD, *3 * [last]])
        found = fit_series(MODEL, RADIUS, readings)
        error = found.secant.value * true / law(true) - 1
        errors.append(error)
        stated.append(error * found.secant.value / found.secant.sd)
    assert abs(np.mean(errors)) < 0.03, name
    assert 0.5 < float(np.sqrt(np.mean(np.square(stated)))) < 1.3, name


@pytest.mark.parametrize("draws", [50, pytest.param(150, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("stiffness", "looks"),
    [
        pytest.param(
            stiffness, looks, marks=[pytest.mark.slow] * ((stiffness, looks) not in ((250.0, 12), (1100.0, 1)))
        )
        for stiffness in (250.0, 600.0, 1100.0)
        for looks in (1, 12)
    ],
)
def test_errors_are_as_large_as_stated(stiffness, looks, draws):
    """Draws of noise, of the robot's place, of the object's power and of the model's factor; the last press may be looked at often."""
    noise, off, at = np.random.default_rng(7), [], []
    poses = [*POSES, *[(0.0, 0.013)] * looks]
    for _ in range(draws):
        power, stiffening = (
            POWER.value + POWER.sd * noise.standard_normal(),
            noise.normal(STIFFENING.value, STIFFENING.sd),
        )
        law = skin(stiffness, max(power, 0.8), max(stiffening, 0.0))
        true = TOP - height(law, *_at_hand(poses[-1]))
        factor = 1 + 0.01 * noise.standard_normal()
        found = fit_series(Factored(factor), RADIUS, seen(law, 3e-5, noise, robot=5e-5, poses=poses))
        off.append((found.secant.value * true / law(true) - 1) / (found.secant.sd / found.secant.value))
        steady = found.stiffness_at(DROP)
        at.append((steady.value / stiffness - 1) / (steady.sd / steady.value))
    assert 0.7 < float(np.sqrt(np.mean(np.square(off)))) < 1.3
    assert 0.7 < float(np.sqrt(np.mean(np.square(at)))) < 1.3


def _at_hand(pose):
    return pose[0], TOP - pose[1]


def test_scatter_beyond_the_stated_deviations_widens_the_answer():
    noise = np.random.default_rng(3)
    readings = seen(spring(600.0, 1.4), 2e-4, noise, poses=[*POSES, *POSES])
    sure = [TopReading(r.stretch, r.hand, r.height, 2e-5) for r in readings]
    assert fit_series(MODEL, RADIUS, sure).chi2 > 4
    assert fit_series(MODEL, RADIUS, sure).drop.sd > 0.4 * fit_series(MODEL, RADIUS, readings).drop.sd


def test_a_known_top_stands_for_the_touch():
    law = spring(600.0, 1.4)
    found = fit_series(MODEL, RADIUS, seen(law, poses=[(0.0, 0.012)]), top=Estimate(TOP, 1e-6))
    assert found.drop.value == pytest.approx(TOP - height(law, 0.0, TOP - 0.012), rel=1e-3)


def test_what_all_heights_share_changes_the_force_alone():
    readings = seen(spring(600.0, 1.4), 2e-5)
    alone, shared = (fit_series(MODEL, RADIUS, readings, common_sd=sd) for sd in (0.0, 3e-4))
    assert shared.force.sd > 2 * alone.force.sd > 0
    assert shared.drop == alone.drop
    assert shared.secant.sd > alone.secant.sd


def test_errors_of_force_and_drop_go_against_each_other():
    found = fit_series(MODEL, RADIUS, seen(spring(300.0, 1.4), 5e-5))
    assert -1 <= found.together < 0


@pytest.mark.parametrize("ratio", [1e-3, 1e3])
def test_an_object_a_thousand_times_softer_or_stiffer_than_the_membrane_ends_in_an_answer_or_a_refusal(ratio):
    stiffness = 300.0 * ratio
    law = spring(stiffness, 1.4)
    found = fit_series(MODEL, RADIUS, seen(law, 2e-5))
    if ratio < 1:
        true = TOP - height(law, POSES[-1][0], TOP - POSES[-1][1])
        assert abs(found.stiffness().value - law(true) / true) < 3 * found.secant.sd
    else:
        with pytest.raises(IllConditioned, match=r"too little to tell; its stiffness is above"):
            found.stiffness()
        with pytest.raises(IllConditioned, match="too little to tell"):
            found.stiffness_at(DROP)


def test_two_readings_say_something_and_say_how_little():
    readings = seen(spring(600.0, 1.4), 5e-5, poses=[(0.0, 0.003), (0.0, 0.012)])
    found = fit_series(MODEL, RADIUS, readings)
    assert 0.02 < found.drop.sd / found.drop.value < 0.4
    assert math.isfinite(found.secant.sd)


GOOD = seen(spring(600.0, 1.4), 5e-5)


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"radius": Estimate(0.0, 0.0)}, InvalidInput, "radius"),
        ({"radius": Estimate(-0.03, 0.0)}, InvalidInput, "radius"),
        ({"radius": Estimate(math.inf, 0.0)}, InvalidInput, "radius"),
        ({"radius": Estimate(0.5, 0.0)}, InvalidInput, "outside the calibrated range"),
        ({"readings": []}, IllConditioned, "no reading"),
        ({"readings": GOOD[-1:]}, IllConditioned, "at one force"),
        ({"readings": [GOOD[-1], GOOD[-1]]}, IllConditioned, "at one force"),
        (
            {"readings": [replace(GOOD[-1], height=GOOD[-1].height - 1e-4 * i) for i in range(3)]},
            IllConditioned,
            "one press",
        ),
        ({"readings": [*GOOD, TopReading(0.3, 0.05, 0.06, 1e-4)]}, InvalidInput, "outside the calibrated range"),
        ({"readings": [*GOOD, TopReading(0.0, 0.02, 0.06, 1e-4)]}, InvalidInput, "outside the calibrated range"),
        ({"readings": [*GOOD, TopReading(0.0, 0.05, math.nan, 1e-4)]}, InvalidInput, "finite"),
        ({"readings": [*GOOD, TopReading(0.0, 0.05, 0.06, 0.0)]}, InvalidInput, "above 0 m"),
        ({"model": Factored(-1.0)}, IllConditioned, "does not grow with depth"),
        ({"power": Estimate(1.5, 0.0)}, InvalidInput, "power"),
        ({"robot_sd": -1.0}, InvalidInput, "robot_sd"),
        ({"top": Estimate(0.06, 0.0)}, InvalidInput, "top"),
    ],
)
def test_readings_without_an_answer_are_refused(change, error, said):
    given_ = {"model": MODEL, "radius": RADIUS, "readings": GOOD, **change}
    with pytest.raises(error, match=said):
        fit_series(given_.pop("model"), given_.pop("radius"), given_.pop("readings"), **given_)


@pytest.mark.parametrize("drop", [0.0, -1e-3, math.nan, math.inf])
def test_a_stiffness_is_told_at_a_drop_above_zero(drop):
    with pytest.raises(InvalidInput, match="drop"):
        fit_series(MODEL, RADIUS, GOOD).stiffness_at(drop)
