"""What a mocks file expects of its run."""

from __future__ import annotations

from dataclasses import dataclass, field

from stretch_bt.runtime.mock_node import pattern_fits
from stretch_bt.source import Mark

__all__ = ["Expectation"]


@dataclass(slots=True)
class Expectation:
    """What a mocks file says of the run: its result, what was visited, what never, and how many ticks at most."""

    result: str | None = None
    visited: list[tuple[str, str | None]] = field(default_factory=list)
    never: list[tuple[str, str | None]] = field(default_factory=list)
    marks: list[tuple[str, Mark]] = field(default_factory=list)  # of every pattern of `visited` and `never`
    ticks_max: int | None = None

    def unmet(self, status: str, ticks: int, seen: set[tuple[str, str]]) -> list[str]:
        """Return what did not come true; `seen` holds (path, STATUS) of every change."""
        found = []
        if self.result is not None and status.lower() != self.result:
            found.append(f"expected {self.result}, the run ended with {status.lower()}")
        found += [f"expected a visit of {_show(p)}" for p in self.visited if not _seen(p, seen)]
        found += [f"expected no visit of {_show(p)}" for p in self.never if _seen(p, seen)]
        if self.ticks_max is not None and ticks > self.ticks_max:
            found.append(f"expected at most {self.ticks_max} ticks, took {ticks}")
        return found


def _seen(wanted: tuple[str, str | None], seen: set[tuple[str, str]]) -> bool:
    pattern, status = wanted
    return any(pattern_fits(pattern, path) and status in (None, s.lower()) for path, s in seen)


def _show(wanted: tuple[str, str | None]) -> str:
    return wanted[0] + (f"#{wanted[1]}" if wanted[1] else "")
