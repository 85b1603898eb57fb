import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.runtime.report.text import number, seconds, with_sd


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
