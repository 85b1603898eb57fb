"""Rows of one domain taken together by setting."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.points import OK, REFERENCE, Row

__all__ = ["Spread", "Summary", "rms", "summarise"]


def rms(values: npt.ArrayLike) -> float:
    """Return the root of the mean square of the values that are there, those that are not a number left out."""
    return float(np.sqrt(np.nanmean(np.square(values))))


@dataclass(frozen=True, slots=True)
class Spread:
    """Median, 95th percentile and largest of some figures."""

    median: float
    p95: float
    largest: float

    @classmethod
    def of(cls, figures: Sequence[float]) -> Spread:
        """Take them together."""
        return cls(float(np.median(figures)), float(np.percentile(figures, 95)), max(figures))


@dataclass(frozen=True, slots=True)
class Summary:
    """One setting: how many cases it answered, CPU and robot seconds, the error of each kind, and the rows without an answer."""

    setting: str
    answered: int
    seconds: Spread | None
    robot_seconds: Spread | None
    errors: dict[str, Spread]
    unanswered: tuple[Row, ...]
    is_reference: bool

    @property
    def series(self) -> str:
        """What the setting is a variant of."""
        return self.setting.partition(":")[0]

    @property
    def variant(self) -> str:
        """Which variant of its series it is."""
        return self.setting.partition(":")[2].strip()


def summarise(rows: Iterable[Row]) -> list[Summary]:
    """Return a summary for each setting, series by series, in the order in which they first come."""
    settings: dict[str, list[Row]] = {}
    for row in rows:
        settings.setdefault(row.setting, []).append(row)
    found = [_summary(setting, group) for setting, group in settings.items()]
    series = list(dict.fromkeys(summary.series for summary in found))
    return sorted(found, key=lambda summary: series.index(summary.series))


def _summary(setting: str, rows: Sequence[Row]) -> Summary:
    answers = [row for row in rows if row.status in (OK, REFERENCE)]
    costs = {(row.case, row.seed): row.cpu_seconds for row in answers if row.cpu_seconds is not None}
    times = {(row.case, row.seed): row.robot_seconds for row in answers if row.robot_seconds is not None}
    kinds: dict[str, list[float]] = {}
    for row in answers:
        if row.error is not None:
            kinds.setdefault(row.error_kind, []).append(row.error)
    return Summary(
        setting,
        len({(row.case, row.seed) for row in answers}),
        Spread.of([*costs.values()]) if costs else None,
        Spread.of([*times.values()]) if times else None,
        {kind: Spread.of(errors) for kind, errors in kinds.items()},
        tuple(row for row in rows if row.status not in (OK, REFERENCE)),
        any(row.status == REFERENCE for row in rows),
    )
