"""Scales of an axis, linear and logarithmic, and the round numbers that stand at it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Linear", "Logarithmic", "Scale", "decades", "round_down", "ticks"]


@dataclass(frozen=True, slots=True)
class Linear:
    """Maps values from `low` to `high` to places from `begin` to `end`, and others beyond these."""

    low: float
    high: float
    begin: float
    end: float

    def place(self, value: float) -> float:
        """Return the place of a value."""
        return self.begin + (self.end - self.begin) * (value - self.low) / (self.high - self.low)

    def ticks(self, count: int) -> list[float]:
        """Return about `count` round numbers between its ends."""
        return ticks(self.low, self.high, count)


@dataclass(frozen=True, slots=True)
class Logarithmic:
    """Maps values between the first and the last of some marks to places from `begin` to `end`, by their logarithm."""

    marks: tuple[float, ...]
    begin: float
    end: float

    def place(self, value: float) -> float:
        """Return the place of a value; one beyond an end is there."""
        share = 0.0 if value <= 0 else math.log(value / self.marks[0]) / math.log(self.marks[-1] / self.marks[0])
        return self.begin + (self.end - self.begin) * min(max(share, 0.0), 1.0)


Scale = Linear | Logarithmic


def ticks(low: float, high: float, count: int) -> list[float]:
    """Return about `count` round numbers between two others; steps are 1, 2 or 5 times a power of ten."""
    span = high - low
    if not (span > 0 and math.isfinite(span)):
        return [low]
    rough = span / count
    power = 10.0 ** math.floor(math.log10(rough))
    step = power * next(m for m in (1, 2, 5, 10) if m * power >= rough * 0.999)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [i * step for i in range(first, last + 1)]


def decades(values: Sequence[float]) -> tuple[float, ...]:
    """Return the powers of ten that hold all values; 1, 2 and 5 times them where they are within one decade or two."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    high = max(high, low + 1)
    if high - low > 2:
        return tuple(10.0**power for power in range(low, high + 1))
    fine = [*(m * 10.0**power for power in range(low, high) for m in (1, 2, 5)), 10.0**high]
    first = max(k for k, mark in enumerate(fine[:-1]) if mark <= min(values) * (1 + 1e-9))
    last = min(k for k, mark in enumerate(fine) if mark >= max(values) * (1 - 1e-9))
    return tuple(fine[first : max(last, first + 1) + 1])


def round_down(value: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9))
