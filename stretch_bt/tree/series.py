"""A list of numbers with their standard deviations, as a loop collects them, and what expressions work out of lists."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from stretch_bt.errors import Absent, NoAnswer
from stretch_bt.units import Estimate

__all__ = ["LIST_FUNCTIONS", "EstimateList", "entries", "errors_of"]

_OF_MEDIAN = math.sqrt(math.pi / 2.0)  # standard deviation of a median over the mean's, of many normal values
_OF_FEW = {1: 1.8373, 2: 1.3213}  # Student's t by degrees of freedom, where its expansion does not hold


class EstimateList(list[Any]):
    """A list whose entry `i` has the standard deviation `sds[i]`, None where it has none."""

    def __init__(self, values: Iterable[Any] = (), sds: Iterable[float | None] = ()) -> None:
        super().__init__(values)
        self.sds = list(sds)


def errors_of(values: Sequence[Any]) -> Sequence[float | None]:
    """Return the standard deviation of each entry, None where it has none."""
    found: Sequence[float | None] = getattr(values, "sds", ())
    return found if len(found) == len(values) else [None] * len(values)


def _some(name: str, values: Sequence[Any]) -> Sequence[Any]:
    if not values:
        raise NoAnswer(f"{name} of a list that is empty")
    return values


def _with(value: float, sd: float | None) -> float:
    return value if sd is None else Estimate(value, sd)


def _average_sd(values: Sequence[float], factor: float) -> float | None:
    """Return the error of an average: from the entries' own errors or from how they scatter, whichever is larger."""
    n, sds = len(values), errors_of(values)
    own = math.sqrt(sum(sd * sd for sd in sds if sd is not None)) / n if None not in sds else None
    spread = statistics.stdev(values) if n > 1 else 0.0  # values that are all the same say nothing of their error
    scatter = spread / math.sqrt(n) * _student(n - 1) if spread > 0 else None
    found = max((sd for sd in (own, scatter) if sd is not None), default=None)
    return None if found is None else found * (factor if n > 2 else 1.0)


def _student(freedom: int) -> float:
    """Return Student's t within which 68.3 % lie, to 1e-3: few values scatter too little by chance."""
    return _OF_FEW.get(freedom, 1.0 + 0.5 / freedom + 0.25 / freedom**2 + 0.0625 / freedom**3)


def _mean(values: Sequence[float]) -> float:
    _some("the mean", values)
    return _with(math.fsum(values) / len(values), _average_sd(values, 1.0))


def _median(values: Sequence[float]) -> float:
    _some("the median", values)
    return _with(float(statistics.median(values)), _average_sd(values, _OF_MEDIAN))


def _entry(values: Sequence[Any], index: int) -> Any:
    sd = errors_of(values)[index]
    return values[index] if sd is None else Estimate(values[index], sd)


def entries(values: Sequence[Any]) -> list[Any]:
    """Return the entries, those with a standard deviation as Estimates."""
    return [value if sd is None else Estimate(value, sd) for value, sd in zip(values, errors_of(values), strict=True)]


def _argmin(values: Sequence[float]) -> int:
    return min(range(len(_some("argmin", values))), key=values.__getitem__)


def _argmax(values: Sequence[float]) -> int:
    return max(range(len(_some("the largest", values))), key=values.__getitem__)


def _at(values: Sequence[Any], index: int) -> Any:
    if not 0 <= index < len(values):
        raise Absent(f"at(..., {index}): the list holds {len(values)}, counted from 0")
    return _entry(values, index)


def _sort(values: Sequence[float]) -> EstimateList:
    order = sorted(range(len(values)), key=values.__getitem__)
    sds = errors_of(values)
    return EstimateList([values[i] for i in order], [sds[i] for i in order])


#: functions of one list, by name; `at` takes an index too
LIST_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "mean": _mean,
    "median": _median,
    "sum": math.fsum,
    "len": len,
    "sort": _sort,
    "argmin": _argmin,
    "at": _at,
    "min": lambda values: _entry(values, _argmin(_some("the smallest", values))),
    "max": lambda values: _entry(values, _argmax(values)),
}
