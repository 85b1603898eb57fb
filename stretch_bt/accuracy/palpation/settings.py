"""What the domain measures: protocols with their steps, at several amounts of averaging."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from stretch_bt.accuracy.palpation.figures import figures
from stretch_bt.accuracy.palpation.palpated import palpated
from stretch_bt.accuracy.palpation.protocols import AVERAGING
from stretch_bt.accuracy.points import OK, Point

__all__ = ["SERIES", "Series", "points"]

SHALLOW = 0.012  # m, the depth limit at which stretch steps are compared: within that of the tree these balloons need no stretch


class Series(NamedTuple):
    """A protocol with its params, and at which levels of averaging it is measured: as a whole, and with `quick`."""

    name: str
    protocol: str
    params: Mapping[str, float]
    levels: tuple[int, ...]
    quick: tuple[int, ...]


SERIES = (
    Series("palpate_stiffness", "shipped", {}, (0, 1, 2, 3), (0, 2)),
    Series("palpate_active", "active", {}, (0, 1, 2, 3), (0,)),
    Series("from zero by 0.5 mm", "from zero", {"step": 0.0005}, (0, 2), ()),
    Series("from zero by 1 mm", "from zero", {"step": 0.001}, (0, 1, 2, 3), (0,)),
    Series("from zero by 2 mm", "from zero", {"step": 0.002}, (0, 2), (0,)),
    *(
        Series(
            f"palpate_stiffness to 12 mm, stretch by {1e3 * step:g} mm",
            "shipped",
            {"max_depth": SHALLOW, "stretch_step": step},
            (0, 2),
            (),
        )
        for step in (0.005, 0.010, 0.020)
    ),
)
FIDELITY = "hertz"
BALLOONS, SEEDS = ("water", "pudding", "seeds"), (0, 1)
QUICK_BALLOONS, QUICK_SEEDS = ("seeds",), (0,)


def points(quick: bool) -> Iterator[Point]:
    """Yield the errors of every run; with `quick` those on one balloon, of few settings."""
    balloons, seeds = (QUICK_BALLOONS, QUICK_SEEDS) if quick else (BALLOONS, SEEDS)
    for series in SERIES:
        for level in series.quick if quick else series.levels:
            for balloon in balloons:
                for seed in seeds:
                    yield from _points(series, level, balloon, seed)


def _points(series: Series, level: int, balloon: str, seed: int) -> Iterator[Point]:
    result, seen = palpated(series.protocol, level, balloon, FIDELITY, seed, series.params)
    case, setting = f"{balloon} balloon, {FIDELITY}", f"{series.name}: {AVERAGING[level]}"
    cpu = result.cpu_seconds
    if result.status == "INTERRUPTED":  # the runner takes the signal for itself
        raise KeyboardInterrupt
    if result.status != "SUCCESS":
        status = f"{result.status.lower()}: {result.reason}"
        yield Point(case, setting, "stiffness", None, cpu, status, seed, result.task_seconds)
        return
    found = figures(result, seen, balloon)
    for kind, error in (("stiffness", found.error), ("stiffness_at_drop", found.drop_error)):
        yield Point(case, setting, kind, abs(error), cpu, OK, seed, found.robot_seconds)
