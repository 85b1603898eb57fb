"""Logarithmic axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Scale", "marks"]


@dataclass(frozen=True, slots=True)
class Scale:
    """Maps values between the first and the last of some marks to places from `begin` to `end`, by their logarithm."""

    marks: tuple[float, ...]
    begin: float
    end: float

    def place(self, value: float) -> float:
        """Return the place of a value; one beyond an end is there."""
        share = 0.0 if value <= 0 else math.log(value / self.marks[0]) / math.log(self.marks[-1] / self.marks[0])
        return self.begin + (self.end - self.begin) * min(max(share, 0.0), 1.0)


def marks(values: Sequence[float]) -> tuple[float, ...]:
    """Return the powers of ten that hold all values; 1, 2 and 5 times them where they are within one decade or two."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    high = max(high, low + 1)
    if high - low > 2:
        return tuple(10.0**power for power in range(low, high + 1))
    fine = [*(m * 10.0**power for power in range(low, high) for m in (1, 2, 5)), 10.0**high]
    first = max(k for k, mark in enumerate(fine[:-1]) if mark <= min(values) * (1 + 1e-9))
    last = min(k for k, mark in enumerate(fine) if mark >= max(values) * (1 - 1e-9))
    return tuple(fine[first : max(last, first + 1) + 1])
