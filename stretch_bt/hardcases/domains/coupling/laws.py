"""Laws of walls and roofs: slopes against differences of the forces, and drops against the forces that they give."""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.expect import Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.objects.buckling import BucklingResponse, plate_buckling_force
from stretch_bt.simulation.objects.roof import RoofOnWalls, RoofResponse
from stretch_bt.simulation.solve import find_root

WALLS = {
    "walls": BucklingResponse(1e4, 1.0, 0.3),
    "walls that snap": BucklingResponse(1e4, 2.0, 0.3, fall=0.4, over=5e-4),
    "stiff walls": BucklingResponse(3e6, 20.0),
}
ROOFS = {
    "a plate": RoofResponse(800.0),
    "a thin sheet": RoofResponse(50.0, 3e8),
    "a stiff plate": RoofResponse(1e5, 1e9),
}
WHOLE = {
    f"{roof} on {walls}": RoofOnWalls(ROOFS[roof], WALLS[walls])
    for roof in ROOFS
    for walls in WALLS
    if not WALLS[walls].fall
}
LAWS: dict[str, BucklingResponse | RoofOnWalls] = {**WALLS, **WHOLE}


def _derived(law: BucklingResponse | RoofOnWalls) -> float:
    """Return the largest error of slopes over the slope at first, on each piece between kinks, against differences."""
    kinks = law.kinks(None)
    worst, first = 0.0, law.force(1e-9)[1]
    for low, high in pairwise((-kinks[0], 0.0, *kinks, 4 * kinks[-1])):
        for drop in low + (high - low) * np.linspace(0.02, 0.98, 7):
            step = 1e-5 * (high - low)
            slope = (law.force(drop + step)[0] - law.force(drop - step)[0]) / (2 * step)
            worst = max(worst, abs(slope - law.force(drop)[1]) / first)
    return float(worst)


def _at_kinks(law: BucklingResponse | RoofOnWalls) -> list[float]:
    """Return the largest jump of the force at kinks, over it, and the least one of the slope, over the larger of the two."""
    jumps, bends = [], []
    for kink in law.kinks(None):
        (before, steep), (after, slack) = (law.force(kink * (1 + part)) for part in (-1e-9, 1e-9))
        jumps.append(abs(after / before - 1))
        bends.append(abs(slack - steep) / max(abs(slack), abs(steep)))
    return [max(jumps), min(min(bends), 1e-4)]


def _at_no_drop(whole: RoofOnWalls) -> float:
    """Return by how much force and slope jump where the drop begins, over the slope."""
    (below, steep), (above, slack) = (whole.force(drop) for drop in (-1e-10, 1e-10))
    return max(abs(above - below) / slack / 2e-10 - 1, abs(steep / slack - 1))


def _plates(width: float) -> float:
    """Return the force at which two plates buckle over the least force of any number of waves in long ones, with simply supported edges."""
    waves = min((n * width / 1.0 + 1.0 / (n * width)) ** 2 for n in range(1, 200))
    return plate_buckling_force(3.0, width, 2) / (2 * waves * math.pi**2 * 3.0 / width)


def _given(walls: BucklingResponse) -> float:
    """Return the largest error of the force at the first drop that gives it, over it, and that no lower drop gives it."""
    worst = 0.0
    for force in np.geomspace(1e-3, 3.0, 25) * walls.critical:
        drop = walls.given(float(force))
        worst = max(worst, abs(walls.force(drop)[0] / force - 1))
        assert all(walls.force(float(part * drop))[0] < force for part in np.linspace(0.0, 0.999, 50))
    return worst


def _sagged(roof: RoofResponse) -> float:
    """Return the largest error of the force at the sag that is found for it, over it."""
    return float(max(abs(roof.force(roof.sag(float(f)))[0] / f - 1) for f in np.geomspace(1e-9, 1e3, 30)))


def _in_series(whole: RoofOnWalls) -> float:
    """Return the largest relative difference between the sum of the drops of roof and walls under a force and the drop of both."""
    drops = np.geomspace(1e-3, 10.0, 25) * whole.kinks(None)[0]
    forces = [whole.force(float(drop))[0] for drop in drops]
    sums = [whole.roof.sag(f) + whole.walls.given(f) for f in forces]
    return float(np.abs(np.array(sums) / drops - 1).max())


def _root(start: float) -> list[float]:
    """Return the root of a falling cubic, and how often it was asked for over what the solve says."""
    asked = []

    def cubic(x: float) -> tuple[float, float]:
        asked.append(x)
        return 0.008 - x**3, -3 * x * x

    found = find_root(cubic, -1.0, 2.0, start, "a case")
    return [found.x, len(asked) / found.iterations]


CASES: tuple[Hard, ...] = (
    *group(
        "a slope that is not the force's own leads Newton's method astray, and a kink that is not reported even more so",
        {f"{name}, derivatives": (partial(_derived, law), Range(0.0, 1e-5)) for name, law in LAWS.items()},
        {f"{name}, kinks": (partial(_at_kinks, law), Value([0.0, 1e-4], abs=1e-6)) for name, law in LAWS.items()},
    ),
    *group(
        "the drop under a force is the inverse of the force at a drop",
        {f"{name}, drops": (partial(_given, walls), Range(0.0, 1e-9)) for name, walls in WALLS.items()},
        {f"{name}, sags": (partial(_sagged, roof), Range(0.0, 1e-9)) for name, roof in ROOFS.items()},
        {f"{name}, drops add up": (partial(_in_series, whole), Range(0.0, 1e-9)) for name, whole in WHOLE.items()},
        {f"{name}, at no drop": (partial(_at_no_drop, whole), Range(-1e-6, 1e-6)) for name, whole in WHOLE.items()},
        {
            f"plates of {1e3 * width:g} mm buckle": (partial(_plates, width), Value(1.0, rel=1e-3))
            for width in (0.02, 0.05)
        },
        {
            f"a root from {start:g}": (partial(_root, start), Value([0.2, 1.0], rel=1e-6))
            for start in (-1.0, 0.0, 0.2, 1.9)
        },
    ),
    *group(
        "a roof that pulls, or is infinitely stiff",
        {
            f"a roof of {linear:g} N/m and {cubic:g} N/m^3": (
                partial(RoofResponse, linear, cubic),
                Refusal(InvalidInput, "a roof needs"),
            )
            for linear, cubic in ((-1.0, 0.0), (math.inf, 0.0), (1.0, -1.0), (1.0, math.inf), (math.nan, 0.0))
        },
    ),
)
