"""Random presses of the sheet: how they are drawn and solved, and some of them solved again on half the mesh.

python -m benchmarks.membrane_random [COUNT]
"""

from __future__ import annotations

import math
import re
import sys
import time
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.press import GAUGE, WIDTH, PressResult, press
from stretch_bt.simulation.membrane.sheet.clamps import OVERLAP
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings

CLAMPED = "provably none: the indenter overlaps a clamp"
BESIDE = "provably none: the indenter does not reach the flat sheet"
SLIPPED = "a limit point, at one depth on two meshes: the sheet slips off"
FAILED = "none found"
ENDS = (CLAMPED, BESIDE, SLIPPED, FAILED)
SAME = 0.1  # of the depth of a limit point, between two meshes
REACH = 0.030  # m; no indenter that is drawn is wider
HALF_MESH = Settings(coarsen=0.5)


class Case(NamedTuple):
    """A press of the default membrane: lengths in m, angles in rad."""

    indenter: Indenter
    stretch: float
    depth: float
    at: tuple[float, float]
    tilt: tuple[float, float]

    @property
    def room(self) -> tuple[float, float]:
        """How far the axis is from the free edge of the flat sheet, were its stretch uniaxial, and from the clamp, m."""
        length = 1 + self.stretch / GAUGE
        return WIDTH / 2 / math.sqrt(length) - abs(self.at[0]), GAUGE / 2 * length - abs(self.at[1])

    @property
    def inside(self) -> bool:
        """Whether the flat sheet reaches past the indenter on all sides."""
        half = self.indenter.diameter / 2 if isinstance(self.indenter, Sphere | Cylinder) else self.depth
        if isinstance(self.indenter, Cube):
            half = self.indenter.side / math.sqrt(2)
        return min(self.room) > half

    def press(self, **options: Any) -> PressResult:
        """Return the press; options are the options of `press`, and may replace the case's values."""
        return press(**self._asdict() | options)


class Outcome(NamedTuple):
    """What became of a case: a press, or the reason for none and which of ENDS that is; `end` is empty where pressed."""

    case: Case
    found: PressResult | None
    reason: str
    end: str
    milliseconds: float


class Again(NamedTuple):
    """A press solved once more at half the mesh size from another start; `reason` says why that gave nothing."""

    case: Case
    first: PressResult
    second: PressResult | None
    reason: str

    @property
    def ratio(self) -> float:
        """How far the two forces are apart, in stated errors of the first; infinite without a second."""
        if self.second is None:
            return math.inf
        assert self.first.force_error is not None
        return abs(self.second.force - self.first.force) / self.first.force_error


def draw(rng: np.random.Generator) -> Case:
    """Return a case whose axis is over the sheet: a point of it, carried along by a uniaxial stretch."""
    diameter, stretch = float(rng.uniform(0.010, 0.030)), float(rng.uniform(0, 0.08))
    shapes: list[Indenter] = [Sphere(diameter), Cylinder(diameter), Cone(math.pi / 4), Cube(diameter)]
    shape, length = shapes[rng.integers(4)], 1 + stretch / GAUGE
    across, along = rng.uniform(-0.5, 0.5, 2).tolist()
    turn, lean = rng.uniform(0, 2 * math.pi), math.radians(rng.uniform(0, 20))
    at = (across * WIDTH / math.sqrt(length), along * GAUGE * length)
    return Case(shape, stretch, float(rng.uniform(1e-6, 0.015)), at, (lean * math.cos(turn), lean * math.sin(turn)))


def solve(case: Case) -> Outcome:
    """Return the outcome of a case; a result that is not finite or not balanced is an error of the solver."""
    began = time.process_time()
    found, reason = None, ""
    try:
        found = case.press()
    except NoEquilibrium as none:
        reason = none.reason
    milliseconds = (time.process_time() - began) * 1e3
    if found is not None:
        assert found.force_error is not None
        values = (found.force, found.force_error, found.residual, found.contact.area)
        assert all(math.isfinite(v) for v in values), case
        assert found.balance < 1e-6, case
    return Outcome(case, found, reason, "" if found else why(case, reason), milliseconds)


def why(case: Case, reason: str) -> str:
    """Return which of ENDS a press without equilibrium is."""
    if reason == OVERLAP:
        return CLAMPED
    if out_of_reach(case):
        return BESIDE
    return SLIPPED if slips(case, reason) else FAILED


def out_of_reach(case: Case) -> bool:
    """Whether the indenter leaves the flat sheet alone, to about 1 um; the sheet then rests as it is."""
    flat = press("sphere:20mm", case.stretch, 1e-4).detail  # so shallow that it moves the edges by nanometres
    assert isinstance(flat, SheetPress)
    points = flat.shape.points(901, 1801).reshape(-1, 3)
    points = points[np.abs(points[:, :2] - case.at).max(axis=1) < REACH]
    points[:, 2] = 0.0
    (body,) = place(case.indenter, case.at, case.tilt, case.depth)
    return bool(body.gap(np.ascontiguousarray(points)).distance.min(initial=math.inf) > 0)


def slips(case: Case, reason: str) -> bool:
    """Whether the path of equilibria ends at one depth on two meshes: a limit point, past which the sheet slips off."""
    ends = [_end(reason)]
    try:
        case.press(settings=HALF_MESH)
    except NoEquilibrium as none:
        ends.append(_end(none.reason))
    return len(ends) == 2 and 0 < max(ends) < (1 + SAME) * min(ends)


def _end(reason: str) -> float:
    """Return the depth, mm, past which a reason says that there is no equilibrium, 0 where it names none."""
    found = re.search(r"past a depth of (\S+) mm", reason)
    return float(found[1]) if found else 0.0


def solve_many(count: int, seed: int = 0) -> list[Outcome]:
    """Return the outcomes of the first cases of a seed."""
    rng = np.random.default_rng(seed)
    return [solve(draw(rng)) for _ in range(count)]


def solve_again(outcomes: Sequence[Outcome], count: int, seed: int = 1) -> Iterator[Again]:
    """Yield some of the presses solved at half the mesh size, each from a press of nine tenths of its depth."""
    solved = [(o.case, o.found) for o in outcomes if o.found is not None]
    for k in np.random.default_rng(seed).permutation(len(solved))[:count]:
        case, found = solved[k]
        try:
            near = case.press(depth=0.9 * case.depth, settings=HALF_MESH)
            yield Again(case, found, case.press(settings=HALF_MESH, start=near), "")
        except NoEquilibrium as none:
            yield Again(case, found, None, none.reason)


def report(count: int) -> None:
    """Print what became of so many random presses, each figure beside the one asked for."""
    press("sphere:20mm", 0.03, 0.01)  # compiles
    outcomes = solve_many(count)
    print(f"{count} random presses (asked: at most {0.005 * count:g} {FAILED})")
    for inside, where in ((True, "indenter all over the sheet"), (False, "indenter reaches over an edge of the sheet")):
        here = [o for o in outcomes if o.case.inside == inside]
        print(f"  {where}: {len(here)}, of which " + "; ".join(f"{sum(o.end == e for o in here)} {e}" for e in ENDS))
    for o in outcomes:
        if o.end in (SLIPPED, FAILED):
            print(f"    {o.end}: {o.case}: {o.reason}")
    ms = np.array([o.milliseconds for o in outcomes])
    print(f"  CPU ms: median {np.median(ms):.0f}, p95 {np.percentile(ms, 95):.0f}, worst {ms.max():.0f}")
    again = list(solve_again(outcomes, max(count // 10, 1)))
    within = sum(a.ratio <= 3 for a in again)
    print(
        f"  again at half the mesh size from another start: {within} of {len(again)} within 3 stated errors (asked 95 %)"
    )
    for a in again:
        if a.ratio > 3:
            print(f"    {a.case}: {a.ratio:.1f} stated errors {a.reason}")


if __name__ == "__main__":
    report(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
