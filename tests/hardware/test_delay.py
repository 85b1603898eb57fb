"""How late records are, against streams whose delays are known."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.hardware.ati.delay import Delay

#: of a record that was on time, s, and of one that was not
NEAR = 0.02


def stream(seed, rate, drift, seconds):
    """Return cycles, times of arrival, s, and delays, s, of a sensor beside a machine that stands still now and then."""
    random = np.random.default_rng(seed)
    cycles = np.arange(int(rate * seconds))
    measured = cycles / rate * (1 + drift)
    arrived = measured + random.exponential(0.0005, len(cycles))
    for begin in np.cumsum(random.exponential(3.0, int(seconds))):
        held = (arrived > begin) & (arrived < begin + random.uniform(0.0, 0.4))
        arrived[held] = arrived[held].max(initial=0.0)
    return cycles, np.maximum.accumulate(arrived), measured


@given(
    seed=st.integers(0, 1000),
    rate=st.sampled_from([125.0, 500.0, 2000.0]),
    drift=st.floats(-1e-4, 1e-4),
    step=st.sampled_from([1, 8]),
    first=st.integers(0, 2**32 - 1),
    delay=st.sampled_from([0.0, 0.3, 1.0]),
)
@settings(max_examples=30, deadline=None)
def test_every_record_is_as_late_as_it_was(seed, rate, drift, step, first, delay):
    cycles, arrived, measured = stream(seed, rate, drift, 20.0)
    late = slice(int(12.0 * rate), int(18.0 * rate))
    arrived[late] += delay
    told = Delay()
    found = [
        told.take((first + step * int(c)) % 2**32, float(at)) for c, at in zip(cycles, 1000.0 + arrived, strict=True)
    ]
    known = slice(int(5.0 * rate), late.stop)
    assert np.abs(np.array(found) - (arrived - measured))[known].max() < NEAR


def test_a_clock_that_changes_its_rate_is_forgiven_in_some_minutes():
    told, late = Delay(), 0.0
    for k in range(200_000):
        late = told.take(k, k / 100.0 * (1 + (1e-4 if k > 100_000 else 0.0)))
    assert late < NEAR


def test_nothing_is_late_before_the_period_is_known():
    told = Delay()
    assert not any(told.take(k, k / 100.0 + (0.5 if k % 7 else 0.0)) for k in range(45))


def test_cycles_that_stand_or_go_back_say_nothing():
    told = Delay()
    for k in range(500):
        told.take(k, k / 100.0)
    assert told.take(499, 9.0) == told.take(3, 9.0) == 0.0
    assert abs(told.take(500, 5.3) - 0.3) < NEAR
