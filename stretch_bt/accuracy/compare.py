"""Rows against those of another time: which errors are worse, and which answers slower."""

from __future__ import annotations

from collections.abc import Iterable

from stretch_bt.accuracy.measuring import LEAST, TIMES
from stretch_bt.accuracy.points import ANSWERED, SKIPPED, Row

__all__ = ["SLOWER", "WORSE", "Comparison"]

WORSE = 1.05  # of the error before, above which one is worse
SLOWER = 1.5  # of the time before


class Comparison:
    """What rows are held against: those of another time by their keys."""

    def __init__(self, old: Iterable[Row]) -> None:
        self.old = {row.key: row for row in old}

    def slower(self, row: Row) -> bool:
        """Return whether an answer took longer than before, both by what the fixed computation took beside them."""
        ratio = self.ratio(row)
        return ratio is not None and ratio > SLOWER

    def ratio(self, row: Row) -> float | None:
        """Return how many times as long as before an answer took; None where that is too short to tell, or not known."""
        old = self.old.get(row.key)
        if (
            old is None
            or not row.kernel_seconds
            or not old.kernel_seconds
            or not row.cpu_seconds
            or not old.cpu_seconds
        ):
            return None
        if min(row.cpu_seconds, old.cpu_seconds) < LEAST:
            return None
        return (row.cpu_seconds / row.kernel_seconds) / (old.cpu_seconds / old.kernel_seconds)

    def flag(self, row: Row) -> str | None:
        """Return what is worse than before, None where nothing is."""
        old = self.old.get(row.key)
        if old is None or SKIPPED in (old.status, row.status):
            return None
        if old.status in ANSWERED and row.status not in ANSWERED:
            return f"{row.status} now, {old.status} before: {row.reason}"
        if _worse(old, row):
            return f"error {row.error:.3g} {row.unit}, before {old.error:.3g}"
        if self.slower(row):
            return f"{self.ratio(row):.2f} times as slow as before, the least of up to {TIMES} runs"
        return None

    def shared(self, rows: Iterable[Row]) -> int:
        """Return how many rows were there before."""
        return sum(row.key in self.old for row in rows)

    def missing(self, rows: Iterable[Row]) -> int:
        """Return how many answers of before, of the domains that are compared, are not among these rows."""
        found = [*rows]
        measured = {row.key for row in found if row.status != SKIPPED}
        domains = {row.domain for row in found}
        return sum(r.domain in domains and r.status != SKIPPED and r.key not in measured for r in self.old.values())


def _worse(old: Row, row: Row) -> bool:
    """Whether an error grew beyond what the reference can tell apart."""
    if old.error is None or row.error is None:
        return False
    return row.error > max(WORSE * old.error, row.reference_error or 0.0)
