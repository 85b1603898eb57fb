"""Units: texts that are parsed, shown and refused; a shown value is parsed to the same."""

import copy
import math
import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from stretch_bt.errors import InvalidInput
from stretch_bt.plain_numbers import is_number, plain_number
from stretch_bt.quantity_text import format_apart, format_duration, format_quantity
from stretch_bt.units import (
    DIMENSIONLESS,
    KINDS,
    Dimension,
    Estimate,
    Length,
    kind_of,
    parse_quantity,
    parse_unit,
    suggest_quantity,
    unit_names,
)
from stretch_bt.within import Within

kinds = st.sampled_from(sorted(KINDS.values(), key=lambda kind: kind.name))
numbers = st.floats(-1e9, 1e9, allow_nan=False).filter(lambda x: x == 0 or abs(x) > 1e-9)

#: text -> SI value, name of the kind
QUANTITIES = {
    "10 mm": (0.010, "Length"),
    "10mm": (0.010, "Length"),
    " 1.5 N ": (1.5, "Force"),
    "-3 um": (-3e-6, "Length"),
    "3 µm": (3e-6, "Length"),
    "+.5 cm": (0.005, "Length"),
    "1e3 mm": (1.0, "Length"),
    "4 kPa": (4000.0, "Pressure"),
    "1.5 N/mm": (1500.0, "Stiffness"),
    "250 mm/s": (0.25, "Speed"),
    "1 mm/s^2": (0.001, "Acceleration"),
    "1 mm/s²": (0.001, "Acceleration"),
    "1 m s^-1": (1.0, "Speed"),
    "2 N mm": (0.002, "Torque"),
    "2 N*mm": (0.002, "Torque"),
    "2 Nmm": (0.002, "Torque"),
    "1/mm": None,
    "3 1/mm": (3000.0, "Curvature"),
    "30 Hz": (30.0, "Frequency"),
    "180 deg": (math.pi, "Angle"),
    "180 deg/s": (math.pi, "AngularSpeed"),
    "2 cm^2": (2e-4, "Area"),
    "2 mm³": (2e-9, "Volume"),
    "2 min": (120.0, "Time"),
    "7 g": (0.007, "Mass"),
}


@pytest.mark.parametrize("text", [t for t, found in QUANTITIES.items() if found])
def test_quantities_are_read_in_si(text: str) -> None:
    expected = QUANTITIES[text]
    assert expected is not None
    value, dimension = parse_quantity(text)
    assert value == pytest.approx(expected[0], rel=1e-12)
    assert dimension == KINDS[expected[1]].dimension
    assert KINDS[expected[1]].parse(text) == value


@pytest.mark.parametrize(
    "text",
    [
        "",
        "mm",
        "ten mm",
        "1,5 mm",
        "1:30",
        "1.2.3 mm",
        "10 furlong",
        "10 mm mm/",
        "10 /mm",
        "1e999 m",
        "nan m",
        "0x10 mm",
        "1/mm",
        "١٠ mm",
        "1² mm",
        "10 mm^٢",
    ],
)
def test_what_is_no_quantity_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput):
        KINDS["Length"].parse(text)


@given(numbers, kinds)
def test_what_is_shown_is_read_again(value: float, kind) -> None:
    text = format_quantity(value, kind, digits=17)
    assert kind.parse(text) == pytest.approx(value, rel=1e-12)


@given(numbers, kinds, st.data())
def test_every_unit_of_a_dimension_means_the_same(value: float, kind, data: st.DataObject) -> None:
    unit = data.draw(st.sampled_from([*unit_names(kind.dimension), kind.unit, kind.si_unit]))
    scale, dimension = parse_unit(unit)
    assert dimension == kind.dimension
    assert kind.parse(f"{value!r} {unit}") == pytest.approx(value * scale, rel=1e-12)


@given(
    st.tuples(*[st.integers(-3, 3)] * 4).map(lambda t: Dimension(*t)),
    st.tuples(*[st.integers(-3, 3)] * 4).map(lambda t: Dimension(*t)),
)
def test_dimensions_multiply_and_divide(a: Dimension, b: Dimension) -> None:
    assert a.times(b).times(b, -1) == a
    assert a.times(DIMENSIONLESS) == a
    assert str(a)


def test_every_kind_is_the_one_of_its_dimension() -> None:
    assert [kind_of(kind.dimension) for kind in KINDS.values()] == list(KINDS.values())
    assert all(parse_unit(kind.si_unit) == (1.0, kind.dimension) for kind in KINDS.values())


#: text, kind, part of what the error says to write
REFUSED = [
    ("10", "Length", "write '10 mm'"),
    (10, "Length", "write '10 mm'"),
    ("10 N", "Length", "use one of m, dm, cm, mm, um"),
    ("10 milimeters", "Length", "write '10 mm'"),
    ("10 MM", "Length", "write '10 mm'"),
    ("1,5 mm", "Length", "write '1.5 mm'"),
    ("3 sec", "Time", "write '3 s'"),
    ("3 seconds", "Time", "write '3 s'"),
    ("90 °", "Angle", "write '90 deg'"),
    ("3 newtons", "Force", "write '3 N'"),
    ("5 in", "Length", "use one of"),
    ("1:30", "Time", "as in '10 s'"),
    (True, "Length", "'10 mm'"),
    (None, "Length", "'10 mm'"),
    ([1], "Length", "'10 mm'"),
    (np.float32(10), "Length", "write '10.0 mm'"),
    (np.bool_(True), "Length", "'10 mm'"),
]


@pytest.mark.parametrize(("text", "kind", "hint"), REFUSED)
def test_the_error_says_what_to_write(text: object, kind: str, hint: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        KINDS[kind].parse(text)
    assert hint in str(caught.value)


@given(st.text("0123456789.,:eE+- mMsNkPa°/^%", max_size=15), kinds)
def test_a_suggestion_is_right_when_it_is_one(text: str, kind) -> None:
    hint = suggest_quantity(text, kind.dimension)
    assert hint
    if hint.startswith("write '"):
        assert kind.parse(hint.split("'")[1]) == kind.parse(hint.split("'")[1])


def test_fields_of_files_carry_units_and_bounds() -> None:
    from typing import Annotated

    adapter = TypeAdapter(Annotated[Length, Within(0.001, 0.01, "Length")])
    assert adapter.validate_python("5 mm") == 0.005
    for text, said in (
        ("5", "write '5 mm'"),
        ("5 cm", "at most 10 mm"),
        ("0 mm", "at least 1 mm"),
        ("10.0001 mm", "10.0001 mm is out of bounds"),
        ("0.99999999999 mm", "0.99999999999 mm is out of bounds"),
    ):
        with pytest.raises(ValidationError, match=said):
            adapter.validate_python(text)


def test_a_share_is_told_apart_from_its_bound() -> None:
    with pytest.raises(InvalidInput, match=r"^100\.0000001 % is out of bounds; write at least 0 % and at most 100 %"):
        Within(0.0, 1.0, percent=True).check(1.000000001)


@given(st.floats(1e-6, 1e6), st.sampled_from([-1, 1]), st.floats(1e-13, 1.0))
def test_a_value_and_the_bounds_that_it_is_past_are_told_apart(bound: float, sign: int, part: float) -> None:
    value, kind = bound * (1 + sign * part), KINDS["Length"]
    told, *bounds = format_apart(kind, value, bound, 2 * bound + 1)
    assert told not in bounds
    assert kind.parse(told) == pytest.approx(value, rel=1e-3)


@given(numbers, st.floats(0, 1e6))
def test_an_estimate_counts_as_its_value_and_keeps_its_sd(value: float, sd: float) -> None:
    made = Estimate(value, sd)
    assert made == value
    assert hash(made) == hash(value)
    assert made + 1 == value + 1
    assert type(made * 2) is float
    assert Estimate(value, sd) == made
    assert Estimate(value, sd + 1) != made
    for again in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made), eval(repr(made), {"Estimate": Estimate})):
        assert (again.value, again.sd) == (value, sd)


def test_a_number_without_a_kind_is_shown_plain() -> None:
    assert format_quantity(0.25, None) == "0.25"
    assert format_quantity(0.25, Dimension(5)) == "0.25"
    assert format_quantity(0.25, Dimension(1)) == "250 mm"


@pytest.mark.parametrize("value", [1, 2.5, np.float32(2.5), np.int64(3), Fraction(1, 2), Estimate(1.0, 0.1)])
def test_numbers_of_any_package_are_numbers(value: Any) -> None:
    assert is_number(value)
    assert plain_number(value) == value
    assert isinstance(plain_number(value), int | float)


@pytest.mark.parametrize(
    "value", [True, None, "1", math.nan, math.inf, np.float32("nan"), 10**400, 1j, np.array(1.0), [1]]
)
def test_what_is_no_finite_number_is_none(value: Any) -> None:
    assert not is_number(value)


@pytest.mark.parametrize(("kind", "text"), [("Pressure", "1 GPa^99"), ("Length", "1 m/um^99")])
def test_a_unit_beyond_every_number_is_refused(kind, text):
    with pytest.raises(InvalidInput, match="larger or smaller than any number"):
        KINDS[kind].parse(text)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.5, "0.5 s"),
        (5.0, "5 s"),
        (90.0, "90 s"),
        (120.0, "2 min"),
        (5400.0, "90 min"),
        (7200.0, "2 h"),
        (61.5, "61.5 s"),
    ],
)
def test_a_duration_is_told_in_the_longest_unit_that_makes_it_whole(seconds: float, text: str) -> None:
    assert format_duration(seconds) == text
