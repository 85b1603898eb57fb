"""What a case may end with: each kind of expectation accepts what it says, and nothing else."""

import math
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.hardcases import Check, Hard, Range, Refusal, Value, Warned, run

FIELD = {"of": lambda found: found.x}


def raising(error):
    def call():
        raise error

    return call


def warning(*texts):
    def call():
        for text in texts:
            warnings.warn(text, UserWarning, stacklevel=1)
        return 1

    return call


#: expectation, what it says, calls that end so, calls that do not
KINDS = {
    "value": (Value(2), "2", [lambda: 2, lambda: np.int64(2)], [lambda: 3, lambda: (2, 2), lambda: math.nan, lambda: None]),
    "nothing": (Value(None), "None", [lambda: None], [lambda: 0, raising(NoContact("none"))]),
    "text": (Value("float32"), "'float32'", [lambda: "float32"], [lambda: "float64"]),
    "relative": (Value(2.0, rel=1e-3), "2 within 0.001 of it", [lambda: 2.001], [lambda: 2.01, lambda: math.nan]),
    "absolute": (Value(0.0, abs=1e-3), "0 within 0.001", [lambda: 1e-3], [lambda: -2e-3]),
    "field": (Value(1, **FIELD), "1", [lambda: SimpleNamespace(x=1)], [lambda: SimpleNamespace(x=2), lambda: 1]),
    "array": (Value(np.zeros(2)), "[0, 0]", [lambda: np.zeros(2)], [lambda: np.zeros(3), lambda: np.ones(2)]),
    "pair": (Value((0.0, 1.0), abs=0.1), "(0, 1) within 0.1", [lambda: (0.05, 1.0)], [lambda: (0.0, 1.2), lambda: 0.0]),
    "range": (Range(0.0, 2.0), "0 to 2", [lambda: 0, lambda: 2.0], [lambda: -1e-9, lambda: 2.1, lambda: math.nan]),
    "half a range": (Range(1.0, **FIELD), "at least 1", [lambda: SimpleNamespace(x=1e9)], [lambda: SimpleNamespace(x=0)]),
    "refusal": (
        Refusal(InvalidInput, r"in m\b"),
        r"InvalidInput: in m\b",
        [raising(InvalidInput("give it in m"))],
        [raising(InvalidInput("give it in mm")), raising(NoContact("in m")), lambda: 1],
    ),
    "any refusal": (Refusal(NoContact), "NoContact", [raising(NoContact("none"))], [raising(ValueError("none"))]),
    "warning": (
        Warned(UserWarning, "finer"),
        "UserWarning: finer",
        [warning("a finer mesh")],
        [warning(), warning("coarse"), warning("a finer mesh", "and more"), raising(NoContact("finer"))],
    ),
    "check": (Check("above 0", lambda found: found > 0), "above 0", [lambda: 1], [lambda: 0, lambda: "text"]),
}  # fmt: skip


def ended(expect, call):
    return run("domain", Hard("name", "why", call, expect))


@pytest.mark.parametrize("kind", KINDS)
def test_each_accepts_what_it_says_and_nothing_else(kind):
    expect, says, right, wrong = KINDS[kind]
    assert expect.says == says
    assert [ended(expect, call).ok for call in right] == [True] * len(right)
    assert [ended(expect, call).ok for call in wrong] == [False] * len(wrong)


@pytest.mark.parametrize("expect", [Value(1), Range(0, 2), Check("one", lambda found: found == 1)])
def test_a_warning_that_nobody_expects_is_a_failure(expect):
    row = ended(expect, warning("beware"))
    assert (row.ok, row.outcome) == (False, "1; warned: UserWarning: beware")


def test_a_row_tells_what_came_and_what_it_cost():
    solved = SimpleNamespace(iterations=7, residual=1e-9)
    row = ended(Check("solved", lambda found: True), lambda: solved)
    assert (row.domain, row.name, row.expected, row.ok) == ("domain", "name", "solved", True)
    assert (row.iterations, row.residual) == (7, 1e-9)
    assert row.seconds >= 0
    assert [*row.to_json()] == [
        "domain", "name", "expected", "outcome", "ok", "iterations", "residual", "seconds",
    ]  # fmt: skip
    lost = ended(Value(1), lambda: SimpleNamespace(iterations=3, residual=math.nan))
    assert (lost.iterations, lost.residual) == (3, None)
    assert ended(Refusal(NoContact), raising(NoContact("x" * 5000))).outcome.endswith("x...")


def test_an_error_of_the_code_is_told_by_its_class():
    assert ended(Value(1), lambda: 1 / 0).outcome == "ZeroDivisionError: division by zero"
    assert "the check broke: TypeError" in ended(Range(0, 1), lambda: None).outcome
