"""The settings that the domain measures: protocols with their steps, at several amounts of averaging."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import product
from typing import NamedTuple

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.palpation.figures import figures
from stretch_bt.accuracy.palpation.palpated import palpated
from stretch_bt.accuracy.palpation.protocols import AVERAGING
from stretch_bt.accuracy.points import FAILED, Answer, Setting

__all__ = ["SERIES", "ProtocolSeries", "jobs"]

SHALLOW = 0.012  # m, the depth limit at which stretch steps are compared: within the tree's own limit these balloons need no stretch
SHIPPED = AVERAGING.index("as shipped")


class ProtocolSeries(NamedTuple):
    """A protocol with its params, and at which levels of averaging it is measured."""

    name: str
    protocol: str
    params: Mapping[str, float]
    levels: tuple[int, ...]


SERIES = (
    ProtocolSeries("palpate_stiffness", "shipped", {}, (0, 1, 2, 3)),
    ProtocolSeries("palpate_active", "active", {}, (0, 1, 2, 3)),
    ProtocolSeries("from zero by 0.5 mm", "from zero", {"step": 0.0005}, (0, 2)),
    ProtocolSeries("from zero by 1 mm", "from zero", {"step": 0.001}, (0, 1, 2, 3)),
    ProtocolSeries("from zero by 2 mm", "from zero", {"step": 0.002}, (0, 2)),
    *(
        ProtocolSeries(
            f"palpate_stiffness to 12 mm, stretch by {1e3 * step:g} mm",
            "shipped",
            {"max_depth": SHALLOW, "stretch_step": step},
            (0, 2),
        )
        for step in (0.005, 0.010, 0.020)
    ),
)
FIDELITY = "hertz"
BALLOONS, SEEDS = ("seeds", "water", "pudding"), (0, 1, 2, 3)
_SECONDS = {"shipped": 2.0, "active": 3.0, "from zero": 3.0}  # CPU time of a run


def jobs() -> Iterator[Job]:
    """Yield every run, seed by seed and balloon by balloon."""
    for seed, balloon, series in product(SEEDS, BALLOONS, SERIES):
        for level in series.levels:
            setting = Setting(series.name, AVERAGING[level])
            default = series.name == SERIES[0].name and level == SHIPPED
            run = partial(_run, series, level, balloon, seed)
            case = f"{balloon} balloon, {FIDELITY}"
            yield Job(case, setting, "stiffness", _SECONDS[series.protocol], run, seed, default)


def _run(series: ProtocolSeries, level: int, balloon: str, seed: int) -> list[Answer]:
    result, seen = palpated(series.protocol, level, balloon, FIDELITY, seed, series.params)
    cpu = result.cpu_seconds
    if result.status == "INTERRUPTED":  # the runner takes the signal for itself
        raise KeyboardInterrupt
    if result.status != "SUCCESS":
        reason = f"{result.status}: {result.reason}"
        return [Answer("stiffness", None, cpu, 0.0, result.task_seconds, status=FAILED, reason=reason)]
    found = figures(result, seen, balloon)
    errors = {"stiffness": found.error, "stiffness_at_drop": found.drop_error}
    return [Answer(kind, abs(error), cpu, 0.0, found.robot_seconds) for kind, error in errors.items()]
