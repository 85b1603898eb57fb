"""The expected end of a hard case: a value, a range, a refusal, a warning, or a check that says what it checks."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from stretch_bt.brief import brief
from stretch_bt.errors import named

#: of an object whose class has no text of its own: another one in each process
_ADDRESS = re.compile(r" at 0x[0-9a-f]+")

__all__ = ["Check", "Ended", "Expectation", "Range", "Refusal", "Value", "Warned"]


@dataclass(frozen=True, slots=True)
class Ended:
    """How a call ended: its answer, or its error, and the warnings on the way."""

    answer: Any = None
    error: Exception | None = None
    warnings: tuple[Warning, ...] = ()

    def __str__(self) -> str:
        if self.error is not None:
            return named(self.error)
        answer = _ADDRESS.sub("", brief(self.answer))
        return "; ".join([answer, *(f"warned: {named(w)}" for w in self.warnings)])


class Expectation(Protocol):
    """The expected end of a call."""

    @property
    def says(self) -> str:
        """The expectation in a few words."""
        ...

    def holds(self, ended: Ended) -> bool:
        """Whether the call ended so."""
        ...


def _itself(answer: Any) -> Any:
    return answer


def _answered(ended: Ended) -> bool:
    return ended.error is None and not ended.warnings


@dataclass(frozen=True, slots=True)
class Value:
    """A value, or numbers within a relative and an absolute tolerance of it; `of` reads it from the answer.

    Without a tolerance the two must be equal. Arrays and tuples are compared entry by entry, and must be of one shape.
    """

    value: Any
    rel: float = 0.0
    abs: float = 0.0
    of: Callable[[Any], Any] = _itself

    @property
    def says(self) -> str:
        """The value and its tolerances."""
        parts = [f"{self.rel:g} of it"] * (self.rel > 0) + [f"{self.abs:g}"] * (self.abs > 0)
        return brief(self.value) + (f" within {' + '.join(parts)}" if parts else "")

    def holds(self, ended: Ended) -> bool:
        """Whether the answer is the value."""
        return _answered(ended) and self._is(self.of(ended.answer))

    def _is(self, found: Any) -> bool:
        import numpy as np

        if not (self.rel or self.abs):
            return bool(np.array_equal(found, self.value))
        here, there = np.asarray(found, dtype=float), np.asarray(self.value, dtype=float)
        return here.shape == there.shape and bool(np.allclose(here, there, rtol=self.rel, atol=self.abs))


@dataclass(frozen=True, slots=True)
class Range:
    """A number from `low` to `high`; `of` reads it from the answer."""

    low: float
    high: float = math.inf
    of: Callable[[Any], float] = _itself

    @property
    def says(self) -> str:
        """The ends."""
        return f"at least {self.low:g}" if self.high == math.inf else f"{self.low:g} to {self.high:g}"

    def holds(self, ended: Ended) -> bool:
        """Whether the answer lies there; not a number never does."""
        return _answered(ended) and bool(self.low <= float(self.of(ended.answer)) <= self.high)


@dataclass(frozen=True, slots=True)
class Refusal:
    """An error of a class whose text has a pattern, with nothing returned."""

    error: type[Exception]
    pattern: str = ""

    @property
    def says(self) -> str:
        """The class and the pattern."""
        return f"{self.error.__name__}: {self.pattern}" if self.pattern else self.error.__name__

    def holds(self, ended: Ended) -> bool:
        """Whether it was refused so."""
        return isinstance(ended.error, self.error) and re.search(self.pattern, str(ended.error)) is not None


@dataclass(frozen=True, slots=True)
class Warned:
    """One warning of a class whose text has a pattern, and an answer beside it."""

    warning: type[Warning]
    pattern: str

    @property
    def says(self) -> str:
        """The class and the pattern."""
        return f"{self.warning.__name__}: {self.pattern}"

    def holds(self, ended: Ended) -> bool:
        """Whether that was warned of, and nothing else."""
        found = [w for w in ended.warnings if isinstance(w, self.warning) and re.search(self.pattern, str(w))]
        return ended.error is None and len(found) == len(ended.warnings) > 0


@dataclass(frozen=True, slots=True)
class Check:
    """Any property of the answer: `says` describes it in words, `check` decides whether it holds."""

    says: str
    check: Callable[[Any], Any]

    def holds(self, ended: Ended) -> bool:
        """Whether the answer passes."""
        return _answered(ended) and bool(self.check(ended.answer))
