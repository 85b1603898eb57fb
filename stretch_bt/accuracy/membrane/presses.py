"""Each press by each solver, against the sheet on fine elements."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from stretch_bt.accuracy.membrane.cases import REFINEMENT, STEP, Case, Variant, cases, reference_settings, variants
from stretch_bt.accuracy.membrane.errors import Reference
from stretch_bt.accuracy.membrane.stand_ins import STAND_INS
from stretch_bt.accuracy.points import OK, REFERENCE, Point
from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.press import PressResult, press
from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["compile_kernels", "points"]

_REFERENCE = "reference: sheet on fine elements"

Answer = tuple[dict[str, float], float]  # error of each kind, and CPU seconds


def compile_kernels() -> None:
    """Solve each kind of press once, so that no time that is measured holds compilation or imports."""
    press("sphere:20mm", 0.03, 0.005, settings=Settings(coarsen=2.0))
    press("sphere:20mm", 0.03, 0.005, solver="axisymmetric")


def points(quick: bool) -> Iterator[Point]:
    """Yield the points of every press."""
    ways = variants(quick)
    for case in cases(quick):
        try:
            fine, coarse = (_press(case, settings) for settings in reference_settings(case))
        except NoEquilibrium as none:
            yield Point(case.name, _REFERENCE, "force", None, None, f"no_equilibrium: {none.reason}")
            continue
        right = Reference.of(fine)
        change = right.errors(coarse)
        own = {kind: value / (REFINEMENT - 1) for kind, value in change.items()}  # as of first order
        yield from _answered(case, _REFERENCE, (own, fine.seconds), REFERENCE)
        for name, stand_in in STAND_INS.items():
            if stand_in.takes(case):
                yield from _tried(case, f"{name}: for the sheet", lambda: stand_in.solve(case, right))  # noqa: B023
        for way in ways:
            if way.takes(case):
                yield from _tried(case, way.name, lambda: _sheet(case, way, right))  # noqa: B023


def _tried(case: Case, setting: str, solve: Callable[[], Answer]) -> Iterator[Point]:
    began = time.process_time()
    try:
        answer = solve()
    except NoEquilibrium as none:
        spent = time.process_time() - began
        yield Point(case.name, setting, "force", None, spent, f"no_equilibrium: {none.reason}")
    else:
        yield from _answered(case, setting, answer, OK)


def _answered(case: Case, setting: str, answer: Answer, status: str) -> Iterator[Point]:
    errors, seconds = answer
    for kind, error in errors.items():
        yield Point(case.name, setting, kind, error, seconds, status)


def _sheet(case: Case, way: Variant, right: Reference) -> Answer:
    start = None
    if way.warm:
        for steps in (2, 1):
            start = _press(case._replace(depth=case.depth - steps * STEP), way.settings, start)
    solved = _press(case, way.settings, start)
    return right.errors(solved), solved.seconds


def _press(case: Case, settings: Settings, start: PressResult | None = None) -> PressResult:
    return press(case.indenter, case.stretch, case.depth, settings=settings, start=start)
