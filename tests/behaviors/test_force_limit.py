"""A limit of force is held by what can hold it: noise does not pass it, a force above it does, soon."""

import math

import numpy as np
import pytest

from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.errors import IllConditioned
from stretch_bt.frames import Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.least_force import least_limit
from stretch_bt.hardware.ur.force_sensing import FORCE_SENSING
from stretch_bt.runtime.context import RunContext

RATE, TICK = 125, 0.05
SENSING = FORCE_SENSING["ur5"]
NOISE = SENSING.deviation / math.sqrt(RATE)


class Arm:
    """An arm whose force is noise about a true one, averaged by its driver as that does it, read once a tick."""

    def __init__(self, force, seed=0, deviation=SENSING.deviation):
        self.force = force
        random = np.random.default_rng(seed)
        count = round(SENSING.filter * RATE)
        drawn = random.normal(0.0, deviation, (200_000, 3)) if deviation else np.zeros((200_000, 3))
        summed = np.cumsum(np.vstack([np.zeros(3), drawn]), axis=0)
        self.errors = (summed[count:] - summed[:-count]) / count
        self.deviation, self.tick = deviation, 0

    def force_noise(self):
        return self.deviation / math.sqrt(RATE)

    def wrench(self, max_age):
        self.tick += 1
        at = self.tick * TICK
        error = self.errors[int(at * RATE)]
        return Reading(Wrench(tuple(error + [0.0, 0.0, self.force(at)])), at, at, self.tick)


class Sensor:
    def __init__(self, force):
        self.force = force

    def wrench(self, max_age):
        return Reading(Wrench((0.0, 0.0, self.force)), 0.0, 0.0, 1)


def test_an_arm_holds_limits_from_three_newtons_on():
    assert least_limit(NOISE) == pytest.approx(3.0, abs=0.01)
    for limit in (0.4, 2.9):
        with pytest.raises(
            IllConditioned, match=r"too noisy to hold a limit of .* it can hold 3 N or more; declare a force sensor"
        ):
            ForceLimit(limit, Arm(lambda at: 0.0), None, RunContext())
    ForceLimit(0.05, Arm(lambda at: 0.0, deviation=0.0), None, RunContext())


@pytest.mark.parametrize("limit", [3.0, *(pytest.param(limit, marks=pytest.mark.slow) for limit in (4.0, 5.0, 8.0))])
@pytest.mark.parametrize("runs", [3, pytest.param(8, marks=pytest.mark.slow)])
def test_noise_does_not_pass_a_limit_in_two_hours(limit, runs):
    """One false alarm in ten hours is stated; as many times 20 min, of other noise each, give none, and half of the limit's force few."""
    alarms = 0
    for seed in range(runs):
        held = ForceLimit(limit, Arm(lambda at: 0.0, seed), None, RunContext())
        alarms += sum(held.passed() is not None for _ in range(24_000))
    assert alarms == 0


@pytest.mark.parametrize("limit", [3.0, 3.5, 4.5])
def test_noise_does_not_pass_a_limit_as_a_motion_begins(limit):
    """Each motion begins its average anew: the first readings alone passed a limit once in a hundred motions."""
    arm = Arm(lambda at: 0.0)
    for _ in range(2000):
        held = ForceLimit(limit, arm, None, RunContext())
        assert not any(held.passed() or held.reached() for _ in range(4))


@pytest.mark.parametrize("limit", [3.0, 5.0, 8.0])
def test_a_force_above_the_limit_is_seen_within_the_time_that_averaging_takes(limit):
    """A step to twice the limit passes it once half of the average is of after the step, and noise adds little to that."""
    held = ForceLimit(limit, Arm(lambda at: 2 * limit if at >= 10.0 else 0.0), None, RunContext())
    ticks = next(k for k in range(1, 1000) if held.passed() is not None)
    assert 10.0 <= ticks * TICK <= 10.0 + 0.35 + SENSING.filter + TICK


@pytest.mark.parametrize(("felt", "arm", "passed"), [(0.3, 0.0, False), (0.5, 0.0, True), (0.0, 8.0, True)])
def test_a_force_sensor_holds_what_the_arm_cannot_and_the_arm_what_it_can(felt, arm, passed):
    held = ForceLimit(0.4, Arm(lambda at: arm), Sensor(felt), RunContext())
    assert any(held.passed() is not None for _ in range(20)) == passed


def test_an_arm_without_noise_is_asked_at_each_tick():
    held = ForceLimit(5.0, Arm(lambda at: 6.0 if at >= 1.0 else 0.0, deviation=0.0), None, RunContext())
    assert next(k for k in range(1, 100) if held.passed() is not None) * TICK == pytest.approx(1.0)
    assert held.passed() == "a force of 6.00 N exceeds the limit of 5 N"
    assert held.margin == 0.0
