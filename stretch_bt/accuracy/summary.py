"""Rows of one domain taken together by setting."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.points import ANSWERED, REFERENCE, SKIPPED, Row, Setting

__all__ = ["MANY", "Spread", "Summary", "rms", "summarise"]

MANY = 20  # figures from which on a 95th percentile says something


def rms(values: npt.ArrayLike) -> float:
    """Return the root of the mean square of the values that are there, those that are not a number left out."""
    return float(np.sqrt(np.nanmean(np.square(values))))


@dataclass(frozen=True, slots=True)
class Spread:
    """Median, 95th percentile and largest of some figures, and how many these are."""

    median: float
    p95: float
    largest: float
    count: int

    @classmethod
    def of(cls, figures: Sequence[float]) -> Spread:
        """Take them together."""
        return cls(float(np.median(figures)), float(np.percentile(figures, 95)), max(figures), len(figures))

    def times(self, scale: float) -> Spread:
        """Return the same in another unit."""
        return Spread(scale * self.median, scale * self.p95, scale * self.largest, self.count)

    @property
    def end(self) -> float:
        """The 95th percentile where there are many figures, else the largest."""
        return self.p95 if self.count >= MANY else self.largest

    @property
    def end_name(self) -> str:
        """The meaning of `end`, in words."""
        return "95th percentile" if self.count >= MANY else f"largest of {self.count}"


@dataclass(frozen=True, slots=True)
class Summary:
    """One setting: its rows with an answer, those without, and those that were not run."""

    setting: Setting
    default: bool
    answers: tuple[Row, ...]
    unanswered: tuple[Row, ...]
    skipped: tuple[Row, ...]

    @property
    def is_reference(self) -> bool:
        """Whether others are compared with it."""
        return any(row.status == REFERENCE for row in self.answers)

    @property
    def answered(self) -> int:
        """How many cases have an answer."""
        return len({(row.case, row.seed) for row in self.answers})

    def errors(self, kind: str) -> Spread | None:
        """Return the errors of a kind."""
        found = [row.error for row in self.answers if row.error_kind == kind and row.error is not None]
        return Spread.of(found) if found else None

    def kinds(self) -> set[str]:
        """Return the kinds of error that it has."""
        return {row.error_kind for row in self.answers if row.error is not None}

    def costs(self, of: Callable[[Row], float | None], kind: str | None = None) -> Spread | None:
        """Return a cost, each case counted once; of a kind of error alone where one is named."""
        rows = [row for row in self.answers if kind in (None, row.error_kind)]
        found = {(row.case, row.seed): cost for row in rows if (cost := of(row)) is not None}
        return Spread.of([*found.values()]) if found else None


def summarise(rows: Iterable[Row]) -> list[Summary]:
    """Return a summary for each setting, series by series, in the order in which they first come."""
    settings: dict[Setting, list[Row]] = {}
    for row in rows:
        settings.setdefault(row.setting, []).append(row)
    series = list(dict.fromkeys(setting.series for setting in settings))
    found = [_summary(setting, group) for setting, group in settings.items()]
    return sorted(found, key=lambda summary: series.index(summary.setting.series))


def _summary(setting: Setting, rows: Sequence[Row]) -> Summary:
    return Summary(
        setting,
        any(row.default for row in rows),
        tuple(row for row in rows if row.status in ANSWERED),
        tuple(row for row in rows if row.status not in (*ANSWERED, SKIPPED)),
        tuple(row for row in rows if row.status == SKIPPED),
    )
