"""Each press by each solver, against the sheet on fine elements."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache, partial
from typing import NamedTuple

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.membrane.cases import (
    DEFAULT,
    REFINEMENT,
    STEP,
    Case,
    Variant,
    cases,
    quick_cases,
    reference_settings,
    variants,
)
from stretch_bt.accuracy.membrane.errors import Reference
from stretch_bt.accuracy.membrane.stand_ins import STAND_INS
from stretch_bt.accuracy.points import OK, REFERENCE, Answer, Setting
from stretch_bt.simulation.membrane.press import PressResult, press
from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["compile_kernels", "jobs"]

_REFERENCE = Setting("reference", "sheet on fine elements")
_SLACK = 3.0  # cost of a slack sheet over a taut one's, about


class _Right(NamedTuple):
    """The reference of a press, its own error by kind, and its CPU time, s."""

    reference: Reference
    own: dict[str, float]
    seconds: float


def compile_kernels() -> None:
    """Solve each kind of press once, so that no time that is measured holds compilation or imports."""
    coarse = Settings(coarsen=2.0)
    for shape in ("sphere:20mm", "cylinder:20mm", "cone:45deg", "cube:20mm"):
        press(shape, 0.03, 0.003, settings=coarse)
    press("sphere:20mm", 0.03, 0.005, settings=Settings.within(0.03))
    case = quick_cases()[0]
    for settings in reference_settings(case):  # their memory is taken from the system once, which is time as well
        _press(case, settings)
    for solver in ("axisymmetric", "hertz"):
        press("sphere:20mm", 0.03, 0.005, solver=solver)


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every press by every solver, those for little time first."""
    first = quick_cases()
    for case in [*first, *(case for case in cases() if case not in first)]:
        yield from _of_case(case, math.inf if quick and case not in first else 1.0)


def _of_case(case: Case, scale: float) -> Iterator[Job]:
    slack = scale * (_SLACK if case.stretch == 0 else 1.0)
    yield Job(case.name, _REFERENCE, "force", 2.0 * slack, partial(_reference, case), group=case.name, once=True)
    for name, stand_in in STAND_INS.items():
        if stand_in.takes(case):
            solve = partial(_stood_in, case, name)
            yield Job(case.name, Setting(name, ""), "force", 0.5 * scale, solve, group=case.name)
    for way in (way for way in variants() if way.takes(case)):
        default = way.settings == DEFAULT
        seconds = slack * (0.3 if way.warm else 0.15) * (10.0 if way.settings.mesh == 1e-3 else 1.0)
        yield Job(case.name, way.name, "force", seconds, partial(_sheet, case, way), default=default, group=case.name)


@lru_cache(maxsize=2)
def _right(case: Case) -> _Right:
    fine, coarse = (_press(case, settings) for settings in reference_settings(case))
    right = Reference.of(fine)
    own = {kind: value / (REFINEMENT - 1) for kind, value in right.errors(coarse).items()}  # as of first order
    return _Right(right, own, fine.seconds)


def _reference(case: Case) -> list[Answer]:
    right = _right(case)
    return [Answer(kind, own, right.seconds, own, status=REFERENCE) for kind, own in right.own.items()]


def _answers(case: Case, errors: dict[str, float], seconds: float) -> list[Answer]:
    own = _right(case).own
    return [Answer(kind, error, seconds, own.get(kind), status=OK) for kind, error in errors.items()]


def _stood_in(case: Case, name: str) -> list[Answer]:
    return _answers(case, *STAND_INS[name].solve(case, _right(case).reference))


def _sheet(case: Case, way: Variant) -> list[Answer]:
    right, start = _right(case).reference, None
    if way.warm:
        for steps in (2, 1):
            start = _press(case._replace(depth=case.depth - steps * STEP), way.settings, start)
    solved = _press(case, way.settings, start)
    return _answers(case, right.errors(solved), solved.seconds)


def _press(case: Case, settings: Settings, start: PressResult | None = None) -> PressResult:
    return press(case.indenter, case.stretch, case.depth, settings=settings, start=start)
