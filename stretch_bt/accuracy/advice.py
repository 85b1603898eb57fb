"""Advice from the rows of a domain for somebody who has to choose a setting, in words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from stretch_bt.accuracy.job import CostAxis, Domain
from stretch_bt.accuracy.points import Kind, Row, Setting
from stretch_bt.accuracy.summary import Spread, Summary, summarise
from stretch_bt.accuracy.table import number

__all__ = ["NOT_MEASURED", "DomainSummaries", "spread"]

NOT_MEASURED = "what was not measured"


class DomainSummaries:
    """The summaries of a domain, to be put into words by kind of error and cost."""

    def __init__(self, domain: Domain, rows: Iterable[Row]) -> None:
        self.kinds, self.peers = domain.kinds, domain.peers
        self.summaries = [s for s in summarise(rows) if not s.is_reference]

    def default(self, kind: str, axis: CostAxis) -> str:
        """Return the default with its error and its cost."""
        return self._words(next((s for s in self._of(kind, axis) if s.default), None), kind, axis)

    def setting(self, setting: Setting, kind: str, axis: CostAxis) -> str:
        """Return a setting with its error and its cost."""
        return self._words(next((s for s in self._of(kind, axis) if s.setting == setting), None), kind, axis)

    def cheapest(self, kind: str, axis: CostAxis, within: float, series: Sequence[str] = ()) -> str:
        """Return the cheapest setting whose error stays within a bound, of some series or of all but peers.

        Of 20 cases and more 95 in 100 must be within, else all, and none may lack an answer that the others of its series have.
        """
        found = [s for s in self._of(kind, axis) if s.setting.series in series or not series]
        least = {
            s.setting.series: min(len(t.unanswered) for t in found if t.setting.series == s.setting.series)
            for s in found
        }
        good = [
            s
            for s in found
            if s.setting.series not in self.peers
            and _errors(s, kind).end <= within
            and len(s.unanswered) == least[s.setting.series]
        ]
        return self._words(min(good, key=lambda s: _costs(s, kind, axis).median, default=None), kind, axis)

    def _of(self, kind: str, axis: CostAxis) -> list[Summary]:
        return [s for s in self.summaries if s.errors(kind) and s.costs(axis.of, kind)]

    def _words(self, summary: Summary | None, kind: str, axis: CostAxis) -> str:
        if summary is None:
            return NOT_MEASURED
        errors, cost = _errors(summary, kind), _costs(summary, kind, axis)
        return f"**{summary.setting}** ({spread(errors, self.kinds[kind])}, {number(cost.median)} {axis.name})"


def spread(errors: Spread, kind: Kind) -> str:
    """Return median and end of some errors, with their unit."""
    unit = "" if kind.unit == "1" else f" {kind.unit}"
    middle, end = number(errors.median * kind.scale), number(errors.end * kind.scale)
    first = f"{middle}{unit}{kind.word}"
    return first if errors.count == 1 else f"{first} in the median, {end}{unit} {errors.end_name}"


def _errors(summary: Summary, kind: str) -> Spread:
    found = summary.errors(kind)
    assert found is not None
    return found


def _costs(summary: Summary, kind: str, axis: CostAxis) -> Spread:
    found = summary.costs(axis.of, kind)
    assert found is not None
    return found
