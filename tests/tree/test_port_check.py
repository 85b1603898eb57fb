"""What a node may write to a port, and what is said of anything else."""

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput, NodeError
from stretch_bt.tree.port_check import PortCheck
from stretch_bt.tree.ports import Behavior, Out, Status, port
from stretch_bt.units import Estimate, Length


@dataclass(frozen=True)
class Dent:
    """A dent."""

    depth: Length
    depth_sd: Length = 0.0
    marks: tuple[str, float] = ("a", 1.0)
    count: int | None = None
    cached: float = field(init=False, repr=False, compare=False)
    inner: "Dent | None" = None
    raw: object = None


#: annotation, value, what is kept
TAKEN = [
    (Length, 0.002, 0.002),
    (Length, 1, 1.0),
    (Length, np.float32(0.5), 0.5),
    (Length, np.int64(2), 2.0),
    (Length, Fraction(1, 4), 0.25),
    (Length, Estimate(0.002, 0.0), Estimate(0.002, 0.0)),
    (float, -3.5, -3.5),
    (int, np.int32(3), 3),
    (bool, np.True_, True),
    (str, "two", "two"),
    (Literal["mean", "either"], "either", "either"),
    (list[Length], [0.001, np.float64(0.002)], [0.001, 0.002]),
    (list[Length], (0.001, np.float64(0.002)), [0.001, 0.002]),
    (list[list[int]], ((1, 2), [3]), [[1, 2], [3]]),
    (tuple[int, ...], (1, 2), [1, 2]),
    (list[int], np.arange(3), [0, 1, 2]),
    (list[list[float]], np.eye(2), [[1.0, 0.0], [0.0, 1.0]]),
    (Literal[1, 2], np.int8(2), 2),
    (Dent, Dent(0.001), Dent(0.001)),
    (Dent, Dent(0.001, 0.0, ("b", 2.0), 3, Dent(None), "x"), Dent(0.001, 0.0, ("b", 2.0), 3, Dent(None), "x")),
    (Dent, Dent(math.inf, count=np.int32(3)), Dent(math.inf, count=3)),
    (Dent | None, None, None),
    (Length | None, None, None),
    (Length | None, 0.001, 0.001),
]
#: annotation, value, what is said of it
REFUSED = [
    (Length, "two", r"takes a Length \(a finite number, m\), not 'two'"),
    (Length, "5 mm", "write 0.005"),
    (Length, "5 s", "not '5 s'$"),
    (Length, None, "not None"),
    (Length, True, "not True"),
    (Length, math.nan, "not nan; raise NoAnswer"),
    (Length, math.inf, "not inf; raise NoAnswer"),
    (Length, np.float64("nan"), "raise NoAnswer"),
    (Length, 10**400, "raise NoAnswer"),
    (Length, Estimate(0.001, -0.1), "standard deviation is -0.1"),
    (Length, Estimate(0.001, math.nan), "standard deviation is nan"),
    (Length, Estimate(math.nan, 0.1), "raise NoAnswer"),
    (Length, np.array(0.1), "finite number"),
    (Length, 1j, "finite number"),
    (int, 2.0, "an int, not 2.0"),
    (bool, 1, "True or False, not 1"),
    (str, 2, "a str, not 2"),
    (Literal["mean", "either"], "maen", "one of mean, either, not 'maen'"),
    (list[Length], 0.001, "a list, each a Length"),
    (list[Length], ["5 mm"], "not '5 mm'"),
    (Dent, 0.001, "a Dent, not 0.001"),
    (Dent | None, "none", "a Dent or None"),
    (Dent, Dent("two"), "its field 'depth' takes a number, not 'two'"),
    (Dent, Dent(math.nan), "its field 'depth' takes a number, not nan"),
    (Dent, Dent(0.001, -0.1), "its field 'depth_sd' takes a number that is not negative, not -0.1"),
    (Dent, Dent(0.001, count=2.5), "its field 'count' takes a whole number or None, not 2.5"),
    (list[Dent], [Dent(0.001), Dent(None)], "its field 'depth' takes a number, not None"),
]


@pytest.mark.parametrize(("annotation", "value", "kept"), TAKEN)
def test_a_value_that_fits_is_kept_as_a_plain_one(annotation: Any, value: Any, kept: Any) -> None:
    found = PortCheck(annotation, None, None).judge(value)
    assert found == kept
    assert type(found) is type(kept)


@pytest.mark.parametrize(("annotation", "value", "told"), REFUSED)
def test_a_value_that_does_not_fit_is_refused(annotation: Any, value: Any, told: str) -> None:
    with pytest.raises(InvalidInput, match=told):
        PortCheck(annotation, None, None).judge(value)


class Writer(Behavior):
    """Has outputs that a test writes."""

    x: Out[Length] = port(min=0.0, max=0.1)
    x_sd: Out[Length]
    share: Out[float | None]
    dent: Out[Dent | None]

    def update(self) -> Status:
        return Status.SUCCESS


@given(st.floats(), st.sampled_from(["x", "x_sd", "share"]))
def test_a_node_writes_a_number_exactly_when_it_lies_within_its_bounds(value: float, name: str) -> None:
    low, high = {"x": (0.0, 0.1), "x_sd": (0.0, math.inf), "share": (-math.inf, math.inf)}[name]
    made = Writer("main/writer")
    fits = math.isfinite(value) and low <= value <= high
    if fits:
        setattr(made, name, value)
        assert made.sinks[name].value == value
    elif not (math.isfinite(value) and math.isclose(value, low, abs_tol=1e-300)) and not math.isclose(value, high):
        with pytest.raises(NodeError, match=rf"^main/writer: wrote '{name}' wrongly: "):
            setattr(made, name, value)


@given(st.floats(), st.floats())
def test_an_estimate_is_written_exactly_when_its_value_and_its_deviation_may_be(value: float, sd: float) -> None:
    made = Writer("main/writer")
    if 0.0 <= value <= 0.1 and 0.0 <= sd < math.inf:
        made.x = Estimate(value, sd)
        assert (made.sinks["x"].value, made.sinks["x"].sd) == (value, sd)
        assert type(made.sinks["x"].value) is float
    elif not math.isclose(value, 0.0, abs_tol=1e-300) and not math.isclose(value, 0.1):
        with pytest.raises(NodeError, match=r"^main/writer: wrote 'x' wrongly: "):
            made.x = Estimate(value, sd)


def test_none_leaves_a_key_without_a_value() -> None:
    made = Writer("main/writer")
    made.dent = Dent(0.001)
    made.dent = None
    assert not made.sinks["dent"].value


def test_a_success_without_an_output_names_it() -> None:
    made = Writer("main/writer")
    made.x = 0.01
    with pytest.raises(
        NodeError, match=r"main/writer: ended with SUCCESS without writing 'x', 'x_sd'; .*Out\[... \| None\]"
    ):
        list(made.tick())
