"""Lists with errors, and what expressions make of lists."""

import math
import statistics

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from stretch_bt.errors import Absent, NoAnswer
from stretch_bt.tree.series import LIST_FUNCTIONS, EstimateList
from stretch_bt.units import Estimate


def test_entries_that_are_all_the_same_say_nothing_of_their_error() -> None:
    for name in ("mean", "median"):
        assert not isinstance(LIST_FUNCTIONS[name]([2.0, 2.0, 2.0]), Estimate)
        assert LIST_FUNCTIONS[name](EstimateList([2.0, 2.0], [0.1, 0.1])).sd == pytest.approx(0.1 / math.sqrt(2))


NUMBERS = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30)


@given(values=NUMBERS)
def test_values_are_those_of_the_statistics_of_python(values: list[float]) -> None:
    made = {
        name: LIST_FUNCTIONS[name](values) for name in ("mean", "median", "sum", "len", "sort", "argmin", "min", "max")
    }
    assert float(made["mean"]) == pytest.approx(statistics.fmean(values), abs=1e-9)
    assert float(made["median"]) == statistics.median(values)
    assert made["sum"] == math.fsum(values)
    assert (made["len"], made["sort"]) == (len(values), sorted(values))
    assert values[made["argmin"]] == float(made["min"]) == min(values)
    assert float(made["max"]) == max(values)


@pytest.mark.parametrize(("name", "most"), [("mean", 1.12), ("median", 1.12)])
@pytest.mark.parametrize("own", [True, False])
def test_the_error_of_an_average_is_how_far_it_is_off(name: str, most: float, own: bool) -> None:
    """From the entries' own errors or from how they scatter; over 2000 lists of 12 entries each."""
    rng = np.random.default_rng(3)
    ratios = []
    for _ in range(2000):
        values = rng.normal(0.0, 0.4, 12).tolist()
        average = LIST_FUNCTIONS[name](EstimateList(values, [0.4] * 12 if own else [None] * 12))
        ratios.append(float(average) / average.sd)
    assert 0.8 < float(np.sqrt(np.mean(np.square(ratios)))) < most


def test_entries_that_scatter_by_more_than_their_errors_say_so() -> None:
    average = LIST_FUNCTIONS["mean"](EstimateList([1.0, 3.0, 2.0, 4.0], [0.01] * 4))
    assert average.sd == pytest.approx(1.2 * statistics.stdev([1, 2, 3, 4]) / 2, rel=0.01)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 9, 30])
def test_the_scatter_of_few_entries_is_that_of_student(count: int) -> None:
    values = [float(i % 3) for i in range(count)]
    factor = stats.t.ppf(0.5 + 0.5 * math.erf(math.sqrt(0.5)), count - 1)
    wanted = factor * statistics.stdev(values) / math.sqrt(count)
    assert LIST_FUNCTIONS["mean"](values).sd == pytest.approx(wanted, rel=1e-3)


def test_an_entry_keeps_its_own_error() -> None:
    values = EstimateList([3.0, 1.0, 2.0], [0.3, 0.1, None])
    assert (LIST_FUNCTIONS["min"](values).sd, LIST_FUNCTIONS["max"](values).sd) == (0.1, 0.3)
    assert (LIST_FUNCTIONS["at"](values, 1), LIST_FUNCTIONS["at"](values, 1).sd) == (1.0, 0.1)
    assert not isinstance(LIST_FUNCTIONS["at"](values, 2), Estimate)
    assert LIST_FUNCTIONS["sort"](values).sds == [0.1, None, 0.3]


def test_one_entry_without_an_error_has_an_average_without_one() -> None:
    assert not isinstance(LIST_FUNCTIONS["mean"]([2.0]), Estimate)


@pytest.mark.parametrize("name", ["mean", "median", "min", "max", "argmin"])
def test_of_nothing_there_is_none(name: str) -> None:
    with pytest.raises(NoAnswer, match="empty"):
        LIST_FUNCTIONS[name]([])


@pytest.mark.parametrize("index", [-1, 3])
def test_an_entry_that_is_not_there_is_absent(index: int) -> None:
    with pytest.raises(Absent, match="holds 3, counted from 0"):
        LIST_FUNCTIONS["at"]([1, 2, 3], index)
