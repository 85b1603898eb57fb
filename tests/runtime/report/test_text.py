import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.runtime.report.scale import ticks
from stretch_bt.runtime.report.text import number, seconds, with_sd

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


@given(st.floats(-1e5, 1e5), st.floats(1e-4, 1e4))
def test_value_and_sd_agree_in_decimals_and_round_right(value: float, sd: float) -> None:
    left, right = with_sd(value, sd).replace("−", "-").split(" ± ")
    assert float(right) == pytest.approx(sd, rel=0.06)
    assert abs(float(left) - value) <= max(0.06 * sd, 6e-4 * abs(value) if sd >= 100 else 0)
    if sd < 10:
        assert len(left.partition(".")[2]) == len(right.partition(".")[2])
        assert re.fullmatch(r"-?\d+\.\d+", left)


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (-2.0, None, "−2"),
        (3, 0.0, "3"),
        ("NaN", 1.0, "NaN"),
        (1.5, "NaN", "1.5"),
        (None, None, "–"),
    ],
)
def test_what_has_no_error_stands_alone(value: object, sd: object, text: str) -> None:
    assert with_sd(value, sd) == text


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (0.41234, 0.0123, "0.412 ± 0.012"),
        (1.23456789, 1e-7, "1.23456789 ± 0.00000010"),
        (-123456.0, 152.0, "−123460 ± 150"),
        (123456, 15.2, "123456 ± 15"),
        (1.23456e-19, 1.5e-21, "1.235e−19 ± 1.5e−21"),
        (0.0, 1.5e-21, "0.0e+00 ± 1.5e−21"),
        (1.0, 1e-300, "1.000000000000000e+00 ± 1.0e−300"),
    ],
)
def test_a_value_has_the_decimals_of_its_sd_however_large_or_small(value: float, sd: float, text: str) -> None:
    assert with_sd(value, sd) == text


@pytest.mark.parametrize(
    ("time", "text"),
    [
        (0.0, "0"),
        (0.00042, "0.00042"),
        (3.5, "3.5"),
        (12345.678, "12345.678"),
        (1.7e9, "1700000000"),
        (-5000.26, "−5000.26"),
    ],
)
def test_times_keep_their_milliseconds(time: float, text: str) -> None:
    assert seconds(time) == text
    assert seconds(None) == "–"


def test_whole_numbers_keep_all_digits() -> None:
    assert (number(123456), number(123456.0), number(True)) == ("123456", "1.235e+05", "True")
