"""Scales of an axis and the round numbers at it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.draw.scale import Linear, Logarithmic, decades, round_down, ticks

RANGES = st.tuples(st.floats(-1e4, 1e4), st.floats(1e-6, 1e6))  # where it starts, in spans, and its span


@given(RANGES, st.integers(2, 12))
def test_ticks_are_few_round_and_inside(span: tuple[float, float], count: int) -> None:
    low, high = span[0] * span[1], (span[0] + 1) * span[1]
    found = ticks(low, high, count)
    slack = 1e-6 * (high - low)
    assert count / 3 - 1 <= len(found) <= count + 1
    assert all(low - slack <= tick <= high + slack for tick in found)
    if len(found) > 1:
        step = found[1] - found[0]
        lead = step / 10 ** math.floor(math.log10(step * 1.0001))
        assert min(abs(lead - m) for m in (1, 2, 5)) < 1e-2


@pytest.mark.parametrize("high", [1.0, math.nan, math.inf])
def test_an_empty_range_has_one_tick(high: float) -> None:
    assert ticks(1.0, high, 4) == [1.0]


@pytest.mark.parametrize(
    ("values", "wanted"),
    [([12.0, 40.0], [10, 20, 50]), ([0.011], [0.01, 0.02]), ([1.0, 3e4], [1, 10, 100, 1e3, 1e4, 1e5])],
)
def test_an_axis_is_marked_from_below_the_least_to_above_the_largest(values, wanted):
    assert list(decades(values)) == pytest.approx(wanted)


@given(st.floats(1e-9, 1e9))
def test_a_length_is_rounded_down_to_one_two_or_five(value):
    found = round_down(value)
    assert value / 2.5 * (1 - 1e-6) < found <= value * (1 + 1e-6)
    assert f"{found:.0e}"[0] in "125"
    assert float(f"{found:.0e}") == pytest.approx(found)


@pytest.mark.parametrize("scale", [Linear(1.0, 100.0, 200.0, 20.0), Logarithmic((1.0, 10.0, 100.0), 200.0, 20.0)])
def test_the_ends_of_a_scale_are_where_it_begins_and_ends(scale):
    assert [scale.place(1.0), scale.place(100.0)] == pytest.approx([200.0, 20.0])


def test_only_a_logarithmic_scale_holds_values_within_its_ends():
    assert Linear(0.0, 1.0, 0.0, 10.0).place(2.0) == pytest.approx(20.0)
    scale = Logarithmic((1.0, 10.0), 0.0, 10.0)
    assert [scale.place(value) for value in (-1.0, 0.0, 0.1, 100.0)] == [0.0, 0.0, 0.0, 10.0]
