"""Rows against earlier ones: which errors are worse, and which answers slower."""

from __future__ import annotations

from collections.abc import Iterable

from stretch_bt.accuracy.measuring import LEAST, TIMES
from stretch_bt.accuracy.points import ANSWERED, SKIPPED, Row

__all__ = ["SLOWER", "WORSE", "Comparison"]

WORSE = 1.05  # times the error before; a larger one is worse
SLOWER = 1.5  # times the time before; a longer one is slower


class Comparison:
    """Earlier rows by their keys, with which new ones are compared."""

    def __init__(self, old: Iterable[Row]) -> None:
        self.old = {row.key: row for row in old}

    def slower(self, row: Row) -> bool:
        """Return whether an answer took longer than before, both relative to the fixed computation beside them."""
        ratio = self.ratio(row)
        return ratio is not None and ratio > SLOWER

    def ratio(self, row: Row) -> float | None:
        """Return the time of an answer over its time before; None where one is too short to compare, or not known."""
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
        """Return in words how a row is worse than before, None where it is not."""
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
        """Return how many rows are compared: those that were there before, and skipped neither then nor now."""
        before = {key for key, row in self.old.items() if row.status != SKIPPED}
        return sum(row.key in before and row.status != SKIPPED for row in rows)

    def missing(self, rows: Iterable[Row]) -> int:
        """Return how many answers of before, of the domains that are compared, are not among these rows."""
        found = [*rows]
        measured = {row.key for row in found if row.status != SKIPPED}
        domains = {row.domain for row in found}
        return sum(r.domain in domains and r.status != SKIPPED and r.key not in measured for r in self.old.values())


def _worse(old: Row, row: Row) -> bool:
    """Whether an error grew, to more than the reference's own error."""
    if old.error is None or row.error is None:
        return False
    return row.error > max(WORSE * old.error, row.reference_error or 0.0)
