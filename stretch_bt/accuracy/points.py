"""One figure: an error, its cost, and what was run to get it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

__all__ = ["OK", "REFERENCE", "Kind", "Point", "Row"]

OK, REFERENCE = "ok", "reference"


class Kind(NamedTuple):
    """How a kind of error is shown: the unit, and how many of it make 1."""

    unit: str
    scale: float


@dataclass(frozen=True, slots=True)
class Point:
    """One figure of a domain.

    `case` is what was asked, `setting` how it was solved, as `series: variant`; `error` is at least 0, and None where
    there is no answer; `cpu_seconds` is the CPU time of the solve, None where nothing ran. `status` is `ok`,
    `reference` for the error of the reference itself, else the reason. `robot_seconds` is the time that a robot
    takes for it, which then is the cost that counts.
    """

    case: str
    setting: str
    error_kind: str
    error: float | None
    cpu_seconds: float | None
    status: str = OK
    seed: int | None = None
    robot_seconds: float | None = None


@dataclass(frozen=True, slots=True)
class Row:
    """A point as it is written: with its domain, and with the versions and the processor that made it."""

    domain: str
    case: str
    setting: str
    seed: int | None
    error: float | None
    error_kind: str
    cpu_seconds: float | None
    status: str
    versions: dict[str, str]
    cpu: str
    robot_seconds: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the fields, in order; `robot_seconds` only where a robot takes any."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        if self.robot_seconds is None:
            del found["robot_seconds"]
        return found
