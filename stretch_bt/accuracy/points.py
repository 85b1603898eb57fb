"""One figure: an error, its cost, and the setting that gave it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

__all__ = [
    "ANSWERED",
    "FAILED",
    "OK",
    "REFERENCE",
    "REFUSED",
    "SKIPPED",
    "STATUSES",
    "Answer",
    "Cost",
    "Kind",
    "Row",
    "Setting",
    "rounded",
]

OK, REFERENCE, REFUSED, FAILED, SKIPPED = "ok", "reference", "refused", "failed", "skipped"
STATUSES = (OK, REFERENCE, REFUSED, FAILED, SKIPPED)
ANSWERED = (OK, REFERENCE)
_DIGITS = 6


class Kind(NamedTuple):
    """A kind of error: the unit in which it is shown, how many of these make 1 of the rows, the unit of the rows, and a word for such a number."""

    unit: str
    scale: float
    si: str = "1"
    word: str = " off"


class Setting(NamedTuple):
    """How a case is solved: a series of settings, drawn as one line, and which of them."""

    series: str
    variant: str

    def __str__(self) -> str:
        return f"{self.series}: {self.variant}" if self.variant else self.series


class Cost(NamedTuple):
    """The cost of an answer beside time, such as presses."""

    name: str
    value: float
    unit: str = "1"


@dataclass(frozen=True, slots=True)
class Answer:
    """One error of a case that was solved with a setting.

    `error` is at least 0, and None where there is no answer, with the `reason`. `reference_error` is the own error of the
    reference: 0 where that is exact, None where it is not known. `cpu_seconds` is CPU time of the solve.
    `robot_seconds` is the time of the robot.
    """

    error_kind: str
    error: float | None
    cpu_seconds: float | None
    reference_error: float | None = None
    robot_seconds: float | None = None
    cost: Cost | None = None
    status: str = OK
    reason: str | None = None


@dataclass(frozen=True, slots=True)
class Row:
    """An answer as it is written: SI, with its case and setting, and with the processor, the commit and the versions that made it.

    `kernel_seconds` is CPU time of a fixed computation beside it, which distinguishes a slow machine from slow code.
    """

    domain: str
    case: str
    setting: Setting
    default: bool
    seed: int | None
    error: float | None
    error_kind: str
    unit: str
    reference_error: float | None
    cpu_seconds: float | None
    robot_seconds: float | None
    cost: Cost | None
    status: str
    reason: str | None
    cpu: str
    commit: str | None
    versions: dict[str, str]
    kernel_seconds: float | None = None

    @property
    def key(self) -> tuple[str, str, Setting, int | None, str]:
        """The key of the row: domain, case, setting, seed and kind of error."""
        return self.domain, self.case, self.setting, self.seed, self.error_kind

    def to_json(self) -> dict[str, Any]:
        """Return the fields, in order."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        cost = None if self.cost is None else self.cost._asdict()
        return found | {"setting": self.setting._asdict(), "cost": cost}


def rounded(value: float | None) -> float | None:
    """Return a number with six significant digits, which is more than any of these figures has."""
    return None if value is None else float(f"{value:.{_DIGITS}g}")
