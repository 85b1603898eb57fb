"""Carrying out a hard case."""

from __future__ import annotations

import math
import time
import warnings
from dataclasses import asdict, dataclass
from typing import Any, Protocol, runtime_checkable

from stretch_bt.errors import named, writable
from stretch_bt.hardcases.expect import Ended
from stretch_bt.hardcases.hard import Hard

__all__ = ["CaseRow", "run"]

#: characters of an outcome that are shown
_SHOWN = 300


@runtime_checkable
class _Iterated(Protocol):
    iterations: int


@runtime_checkable
class _Balanced(Protocol):
    residual: float


@dataclass(frozen=True, slots=True)
class CaseRow:
    """The outcome of a case; `seconds` is CPU time, `iterations` and `residual` come from a solver's answer, else None."""

    domain: str
    name: str
    expected: str
    outcome: str
    ok: bool
    iterations: int | None
    residual: float | None
    seconds: float

    def to_json(self) -> dict[str, Any]:
        """Return the fields, in order."""
        return asdict(self)


def run(domain: str, case: Hard) -> CaseRow:
    """Carry out a case, and return its outcome.

    A warning that is not expected is a failure, as is an error of any class.
    """
    began = time.process_time()
    ended = _ended(case)
    seconds = time.process_time() - began
    ok, outcome = _judged(case, ended)
    return CaseRow(domain, case.name, case.expect.says, outcome, ok, *_effort(ended.answer), seconds)


def _ended(case: Hard) -> Ended:
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            answer, error = case.call(), None
        except Exception as broken:
            answer, error = None, broken
    return Ended(answer, error, tuple(w.message for w in heard if isinstance(w.message, Warning)))


def _judged(case: Hard, ended: Ended) -> tuple[bool, str]:
    text = str(ended)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            ok = case.expect.holds(ended)
    except Exception as broken:
        ok, text = False, f"{text}; the check broke: {named(broken)}"
    short = writable(text)
    return ok, short if len(short) <= _SHOWN else f"{short[:_SHOWN]}..."


def _effort(answer: Any) -> tuple[int | None, float | None]:
    iterations = int(answer.iterations) if isinstance(answer, _Iterated) else None
    residual = float(answer.residual) if isinstance(answer, _Balanced) else math.nan
    return iterations, residual if math.isfinite(residual) else None
