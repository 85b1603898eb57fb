"""A soft object in series with the membrane: its curve from heights of its top."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from stretch_bt.model import POWER, STIFFENING, ForceModel, TopReading, fit_series
from stretch_bt.units import Estimate

MODEL = ForceModel.default()
RADIUS = Estimate(0.03, 0.0)
TOP = 0.06
DROP = 1.5e-3
#: stretch and depth of the hand past first contact: a touch, then presses
POSES = [(0.0, 0.002), (0.0, 0.003), (0.0, 0.004), (0.0, 0.010), (0.02, 0.012)]


def height(law, stretch, hand, factor=1.0):
    """Return the height of the top at which the membrane's force, a factor times the model's, is the object's."""
    return brentq(
        lambda h: factor * MODEL.predict(RADIUS.value, stretch, max(h - hand, 0.0))[0] - law(TOP - h),
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


class Factored:
    """The default model with its force times a factor, or falling with depth where the factor is negative."""

    def __init__(self, factor):
        self.factor, self.range = factor, MODEL.range

    def predict(self, radius, stretch, depth):
        force, sd = MODEL.predict(radius, stretch, depth)
        if self.factor < 0:
            return 1.0 - force, sd
        return self.factor * force, self.factor * sd


#: a ladder of touches, a press, and one that lowers the top by 3 mm: the readings determine the power
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


@pytest.mark.parametrize("looks", [1, 8])
def test_looks_at_one_press_share_the_error_of_the_force_model(looks):
    """Draws of a model that is off by its stated error, alike in all looks at a press: errors are as large as stated, and so is the scatter."""
    noise, off, chi2 = np.random.default_rng(3), [], []
    poses, law, sd = [(0.0, 0.003), (0.0, 0.013)], skin(250.0, POWER.value, STIFFENING.value), 1e-5
    known = {"power": Estimate(POWER.value, 1e-3), "stiffening": Estimate(STIFFENING.value, 1e-3), "robot_sd": 0.0}
    for _ in range(80):
        readings = []
        for pose in poses:
            force, error = MODEL.predict(RADIUS.value, *pose)
            top = height(law, *_at_hand(pose), 1 + error / force * noise.standard_normal())
            count = looks if pose == poses[-1] else 1
            readings += [TopReading(*_at_hand(pose), top + sd * noise.standard_normal(), sd) for _ in range(count)]
        found = fit_series(MODEL, RADIUS, readings, **known)
        drop = TOP - height(law, *_at_hand(poses[-1]))
        compliance = brentq(lambda drop, force: law(drop) - force, 0.0, 0.02, args=(found.reference,))
        pairs = (found.top, TOP), (found.drop, drop), (found.compliance, compliance)
        off.append([(estimate.value - true) / estimate.sd for estimate, true in pairs])
        chi2.append(found.chi2)
    ratios = np.sqrt(np.mean(np.square(off), axis=0))
    assert np.all((ratios > 0.7) & (ratios < 1.3)), ratios
    assert 0.7 < np.mean(chi2) < 1.3


def test_the_error_of_a_radius_at_the_end_of_the_range_counts():
    least = MODEL.range.radius[0]
    readings = seen(spring(1000.0, 1.2))
    sds = [fit_series(MODEL, Estimate(least, sd), readings).force_sd for sd in (0.0, 5e-4)]
    assert sds[1] > 1.01 * sds[0]
