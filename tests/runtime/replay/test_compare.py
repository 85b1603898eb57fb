"""What counts as the same decision, and what as last digits."""

import copy
import dataclasses
import json
import typing
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.perception import Dimension, Solid
from stretch_bt.runtime.record.plain import plain
from stretch_bt.runtime.replay.compare import ANGLES, compare
from stretch_bt.tree.registry import object_types
from stretch_bt.tree.types import annotations_of
from stretch_bt.units import Angle


def write(value: Any, **fields: Any) -> dict[str, Any]:
    return {"type": "write", "tick": 1, "time": 0.05, "key": "k", "path": "main", "value": value, **fields}


def event(kind: str, **fields: Any) -> dict[str, Any]:
    return {"type": kind, "tick": 1, "time": 0.05, **fields}


def array(change: float) -> Any:
    values = np.linspace(-1.0, 1.0, 30_000)
    values[15_000:] += change
    return plain(values)


SOLID = Solid("block", {"height": Dimension(0.04, 1e-4, {})}, 0.03, -0.02, 0.04, 0.1, ())
OLD_SOLID = {name: value for name, value in plain(SOLID).items() if name not in ("x", "y", "z")} | {
    "middle": plain(SOLID.middle)
}
#: recorded, replayed, whether they are the same
CASES = {
    "a digit": (write(0.06356517458916637), write(0.06356517458916636), True),
    "just within": (write(1.0), write(1.0 + 0.99e-6), True),
    "just outside": (write(1.0), write(1.0 + 1.01e-6), False),
    "within the deviation": (write(1.0, sd=0.1), write(1.0 + 0.99e-4, sd=0.1), True),
    "outside the deviation": (write(1.0, sd=0.1), write(1.0 + 1.01e-4, sd=0.1), False),
    "a deviation itself": (write(1.0, sd=0.1), write(1.0, sd=0.1 + 1e-6), False),
    "a deviation gone": (write(1.0, sd=0.1), write(1.0), False),
    "a field with its deviation": (write({"r": 1e-9, "r_sd": 1e-3}), write({"r": 9e-7, "r_sd": 1e-3}), True),
    "a field without": (write({"r": 1e-9, "s_sd": 1e-3}), write({"r": 9e-7, "s_sd": 1e-3}), False),
    "an angle": (write({"heading": 1.7e-4}), write({"heading": 1.7e-4 + 0.9e-6}), True),
    "another angle": (write({"heading": 1.7e-4}), write({"heading": 1.7e-4 + 1.1e-6}), False),
    "a turn": (write({"rotation": [0.0, 0.0, 1e-5]}), write({"rotation": [0.0, 0.0, 1e-5 + 9e-7]}), True),
    "a component beside large ones": (write([1e-17, 0.1]), write([3e-17, 0.1]), True),
    "a component": (write([1e-6, 0.1]), write([3e-6, 0.1]), False),
    "a vector with deviations": (
        write({"c": [0.0, 1.0], "c_sd": [1.0, 1e-9]}),
        write({"c": [9e-4, 1.0], "c_sd": [1.0, 1e-9]}),
        True,
    ),
    "a truth for a number": (write(True), write(1), False),
    "a number for a truth": (write({"a": [0.0]}), write({"a": [False]}), False),
    "a whole number for another": (write(1), write(1.0), True),
    "the sign of nothing": (write(0.0), write(-0.0), True),
    "a count": (write(1_000_001), write(1_000_002), False),
    "no number": (write("NaN"), write(1.0), False),
    "no number in a log that was edited": (write(float("nan")), write(1.0), False),
    "a whole number beyond every float": (write(10**400), write(1.0), False),
    "a word": (write("left"), write("right"), False),
    "an array in its last digits": (write(array(0.0)), write(array(1e-13)), True),
    "an array": (write(array(0.0)), write(array(1e-4)), False),
    "an array of the other sign": (write(array(0.0)), write(plain(-np.linspace(-1.0, 1.0, 30_000))), False),
    "a scalar of the other sign": (write(plain(np.array(0.5))), write(plain(np.array(-0.5))), False),
    "one sign of many": (write(plain(np.ones(8000))), write(plain(np.r_[np.ones(7999), -1.0])), False),
    "an array in another order": (write(plain(np.arange(9.0))), write(plain(np.arange(9.0)[::-1])), False),
    "an array where others are unknown": (
        write(plain(np.array([np.nan, 1.0, 2.0]))),
        write(plain(np.array([1.0, np.nan, 2.0]))),
        False,
    ),
    "an array of an older record": (
        write({k: v for k, v in array(0.0).items() if k != "weighted"}),
        write(array(0.0)),
        True,
    ),
    **{
        f"a solid of an older record, {name}": (write(OLD_SOLID), write(plain(dataclasses.replace(SOLID, x=x))), same)
        for name, x, same in (
            ("unmoved", 0.03, True),
            ("in its last digits", 0.03 + 1e-12, True),
            ("moved", 0.04, False),
        )
    },
    "a solid without a place": (write(OLD_SOLID), write({"kind": "block", "heading": 0.1}), False),
    "another shape": (write(plain(np.zeros(3))), write(plain(np.zeros(4))), False),
    "an array of counts": (write(plain(np.zeros(3, int))), write(plain(np.ones(3, int))), False),
    "another status": (event("status", path="m", status="SUCCESS"), event("status", path="m", status="FAILURE"), False),
    "a reason in its last digits": (
        event("status", path="m", status="FAILURE", reason="it is 2.50 mm high"),
        event("status", path="m", status="FAILURE", reason="it is 2.49 mm high"),
        True,
    ),
    **{
        f"a reason with {old} for {new}": (
            *(event("status", path="m", reason=f"it is {n} high") for n in (old, new)),
            same,
        )
        for old, new, same in (
            ("2.50 mm", "2.48 mm", False),
            ("2.50 mm", "25.0 mm", False),
            ("2.50 mm", "-2.50 mm", False),
            ("2.5 mm", "2.49 mm", True),
            ("3 mm", "2.99 mm", True),
            ("1.2e-05 m", "1.3e-05 m", True),
            ("1.2e-05 m", "1.4e-05 m", False),
            ("0.3 N", "0.2 N", True),
            ("123456.7890", "123456.7892", True),
            ("-5 mm", "-6 mm", False),
            ("3 presses", "4 presses", False),
            ("1e999", "2e-999", False),
        )
    },
    "another reason": (
        event("status", path="m", status="FAILURE", reason="it is 2.50 mm high"),
        event("status", path="m", status="FAILURE", reason="it is gone"),
        False,
    ),
    "a command": (
        event("command", device="arm", name="move", arguments={"speed": 0.01}, owner="m"),
        event("command", device="arm", name="move", arguments={"speed": 0.01 + 1e-15}, owner="m"),
        True,
    ),
    "another speed": (
        event("command", device="arm", name="move", arguments={"speed": 0.01}, owner="m"),
        event("command", device="arm", name="move", arguments={"speed": 0.0101}, owner="m"),
        False,
    ),
    "a motion": (event("motion", state="done"), event("motion", state="blocked"), False),
    "another time": (event("stop"), event("stop") | {"time": 0.1}, False),
}


@pytest.mark.parametrize(("old", "new", "same"), CASES.values(), ids=CASES)
def test_last_digits_are_told_from_decisions(old: Any, new: Any, same: bool) -> None:
    found = compare([event("header"), old, event("stop")], [event("header"), new, event("stop")])
    identical = json.dumps(old, sort_keys=True) == json.dumps(new, sort_keys=True)
    assert (found.identical, found.same) == (identical, same)
    assert found.first == (None if identical else (old, new))
    assert found.largest <= 1e-6 or not same


@pytest.mark.parametrize("left_out", range(3))
def test_an_event_more_or_less_is_a_difference(left_out: int) -> None:
    events = [event("stop", reason=str(n)) | {"tick": n} for n in range(3)]
    fewer = events[:left_out] + events[left_out + 1 :]
    for old, new in ((events, fewer), (fewer, events)):
        found = compare(old, new)
        assert (found.identical, found.same) == (False, False)
        assert found.first is not None


def test_the_decision_comes_before_the_digit() -> None:
    old = [write(1.0), write(2.0), write("a")]
    found = compare(old, [write(1.0), write(2.0 + 1e-12), write("b")])
    assert found.first == (write("a"), write("b"))
    assert found.largest == pytest.approx(5e-13, rel=1e-3)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats(-1e300, 1e300) | st.text() | st.integers(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner, max_size=4),
    max_leaves=12,
)


@given(JSON)
def test_any_value_is_the_same_as_itself_and_as_its_last_digits(value: Any) -> None:
    found = compare([write(value)], [copy.deepcopy(write(value))])
    assert (found.identical, found.same, found.largest, found.first) == (True, True, 0.0, None)
    assert compare([write(value)], [write(_nudged(value))]).same


def _nudged(value: Any) -> Any:
    if isinstance(value, float):
        return value * (1 + 1e-15)
    if isinstance(value, list):
        return [_nudged(item) for item in value]
    return {name: _nudged(item) for name, item in value.items()} if isinstance(value, dict) else value


def test_every_angle_of_a_record_is_known_as_one() -> None:
    fields = ((name, hint) for cls in object_types().values() for name, hint in annotations_of(cls).items())
    angles = {name for name, hint in fields if Angle in (hint, *typing.get_args(hint))}
    assert angles
    assert {name for name in angles if not name.endswith("_sd")} <= ANGLES
