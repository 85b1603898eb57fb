import json
import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.runtime.record.plain import dumps, plain

LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters(codec=None))
VALUES = st.recursive(LEAVES, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=20)


class Rule(Enum):
    MEAN = "mean"


@dataclass
class Ball:
    radius: float
    rule: Rule
    points: Any


def refuse_constant(name: str) -> None:
    raise AssertionError(f"{name} is not JSON")


def same(got: Any, value: Any) -> bool:
    if isinstance(value, float) and not math.isfinite(value):
        return got == {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}[str(value)]
    if isinstance(value, list):
        return len(got) == len(value) and all(map(same, got, value))
    if isinstance(value, dict):
        return got.keys() == value.keys() and all(same(got[key], value[key]) for key in value)
    return type(got) is type(value) and got == value


@given(VALUES)
def test_any_json_value_survives_on_one_line(value: Any) -> None:
    line = dumps(plain(value))
    assert b"\n" not in line
    assert same(json.loads(line, parse_constant=refuse_constant), value)


@given(st.dictionaries(st.text(), st.integers()))
def test_order_of_keys_does_not_matter(value: dict[str, int]) -> None:
    assert dumps(plain(value)) == dumps(plain(dict(reversed(value.items()))))


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (np.float64(0.1), 0.1),
        (np.float32(0.5), 0.5),
        (np.float64("nan"), "NaN"),
        (np.int16(-3), -3),
        (np.bool_(True), True),
        (np.str_("a"), "a"),
        (
            np.array(-2.5),
            {
                "shape": [],
                "dtype": "float64",
                "finite": 1,
                "largest": 2.5,
                "mean": 2.5,
                "weighted": pytest.approx(-1.545, rel=1e-3),
            },
        ),
        (MotionState.DONE, "done"),
        ({Rule.MEAN: (1, 2)}, {"mean": [1, 2]}),
        ({3, 1, 2}, [1, 2, 3]),
        (object(), {"type": "object"}),
    ],
)
def test_other_values(value: Any, expected: Any) -> None:
    got = plain(value)
    if isinstance(expected, dict) and "shape" in expected:
        got.pop("sha256")
    assert got == expected
    assert type(got) is type(expected)


def test_dataclass_gives_fields_and_arrays_give_digests() -> None:
    points = np.arange(12.0).reshape(4, 3)
    got = plain(Ball(0.02, Rule.MEAN, points))
    digest = got["points"].pop("sha256")
    sizes = {"finite": 12, "largest": 11.0, "mean": pytest.approx(5.5, rel=1e-9)}
    sizes["weighted"] = pytest.approx(np.mean(np.arange(12.0) * (np.arange(1, 13) * 40503 % 65536)) / 65536, rel=1e-8)
    assert got == {"radius": 0.02, "rule": "mean", "points": {"shape": [4, 3], "dtype": "float64", **sizes}}
    assert len(digest) == 16
    changed = points.copy()
    changed[3, 2] += 1e-15 * changed[3, 2]
    assert plain(points)["sha256"] == digest == plain(np.asfortranarray(points))["sha256"]
    assert plain(changed)["sha256"] != digest


def test_arrays_without_a_stable_content_have_no_digest() -> None:
    assert plain(np.array([object()])) == {"shape": [1], "dtype": "object"}
    assert "sha256" in plain(np.array(["2020-01-01"], dtype="datetime64[s]"))


def test_a_value_that_contains_itself_ends() -> None:
    knot: list[Any] = []
    knot.append(knot)
    assert dumps(plain(knot)).endswith(b'{"type":"list"}' + b"]" * 12)
