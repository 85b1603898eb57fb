"""A lump that is rolled, pressed and flattened: any force, yield, step, spin and number of directions, and nonsense."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.dough.directions import directions
from stretch_bt.simulation.dough.lump import STEP, Lump, cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.random import normals
from stretch_bt.simulation.dough.roll_kernel import smooth

EDGE, WEIGHT = 0.025, 0.19
DOUGH = Dough(5e3, 1e5)
USUAL: Mapping[str, Any] = {"force": 1.0, "dough": DOUGH, "spin": 0.05, "count": 500, "leg": 0.01}
ROLLED: dict[str, dict[str, Any]] = {
    f"force of {group_:g} Y R^2": {"force": group_ * 5e3 * (EDGE * 0.62) ** 2} for group_ in (0.01, 0.1, 1.0, 10.0)
} | {
    "soft": {"dough": Dough(1.0, 20.0)},
    "hard": {"dough": Dough(1e9, 2e10)},
    "no springback": {"dough": Dough(5e3)},
    "no smoothing": {"dough": Dough(5e3, 1e5, tension=0.0)},
    "force 0": {"force": 0.0},
    "grazing": {"force": 1e-9},
    "no spin": {"spin": 0.0},
    "wild spin": {"spin": 5.0},
    "100 directions": {"count": 100},
    "2000 directions": {"count": 2000},
    "8000 directions": {"count": 8000},
    "one long step": {"leg": 2.0},
    "tiny steps": {"leg": 1e-5},
}


def volume(lump: Lump) -> float:
    """Return the volume within the radii of a lump, m^3."""
    return float(np.sum(lump.radii**3) * lump.directions.solid_angle / 3)


def tumbled(lump: Lump, seed: int) -> Lump:
    """Return a lump that lies otherwise."""
    turned = np.random.default_rng(seed).standard_normal(4)
    return replace(lump, quaternion=turned / np.linalg.norm(turned))


def _path(kind: str) -> Any:
    t = np.linspace(0, 2 * math.pi, 65 if kind == "circle" else 97)
    circle, eight = 0.030 * np.stack([np.cos(t), np.sin(t)]), 0.045 * np.stack([np.sin(t), 0.8 * np.sin(t) * np.cos(t)])
    return np.diff((circle if kind == "circle" else eight).T, axis=0)


def along(
    lump: Lump, kind: str, travel: float, dough: Dough | None = DOUGH, force: float = 1.0, **options: Any
) -> Lump:
    """Return a lump after so many metres of a path."""
    done, legs = 0.0, _path(kind)
    while done < travel:
        for leg in legs:
            lump, _ = lump.rolled(tuple(leg), force, dough, weight=WEIGHT, **options)
            done += math.hypot(*leg)
    return lump


def _rolled(options: Mapping[str, Any]) -> tuple[Lump, bool]:
    """Return a lump after 40 legs in all directions, and whether all heights on the way are finite."""
    case = {**USUAL, **options}
    lump, finite = tumbled(cube(EDGE, case["count"]), 4), True
    for k in range(40):
        way = (case["leg"] * math.cos(k), case["leg"] * math.sin(k))
        lump, steps = lump.rolled(way, case["force"], case["dough"], weight=WEIGHT, spin=case["spin"], seed=k)
        finite = finite and bool(np.isfinite(steps).all())
    return lump, finite


def _whole(found: tuple[Lump, bool]) -> bool:
    lump, finite = found
    sizes = lump.radii.min() > 0.04 * lump.ball and lump.radii.max() < 3 * lump.ball
    return finite and abs(volume(lump) / EDGE**3 - 1) < 1e-12 and bool(sizes)


def _revolved(turns: int) -> list[float]:
    """Return steps a turn, relative change of volume, and the length of the quaternion less 1, after turns of 50 revolutions."""
    lump = cube(EDGE, 100)
    leg = 2 * lump.ball * 100 * math.pi
    for turn in range(turns):
        way = (leg * math.cos(turn), leg * math.sin(turn))
        lump, _ = lump.rolled(way, 1.0, DOUGH, weight=WEIGHT, spin=0.05)
    off = round(lump.steps - turns * 50 * 60, -1)
    return [off, volume(lump) / EDGE**3 - 1, float(np.linalg.norm(lump.quaternion)) - 1]


def _lost(travel: float, lost: float) -> tuple[float, float]:
    """Return the height that a press takes over the wanted one, and the volume over the volume before."""
    lump = along(tumbled(cube(EDGE), 3), "eight", travel) if travel else cube(EDGE)
    after = lump.flattened(lost)
    return (lump.height - after.height) / lost, volume(after) / EDGE**3


def _kept(dough: Dough | None) -> tuple[float, bool]:
    """Return the largest relative change of a radius, and whether the lump has turned, after 0.3 m."""
    start = tumbled(cube(EDGE), 1)
    after = along(start, "eight", 0.3, dough)
    turned = np.abs(after.quaternion - start.quaternion).max() > 0.1
    return float(np.abs(after.radii / start.radii - 1).max()), bool(turned)


def _rounded(kind: str, spin: float) -> float:
    """Return the median spread of radii of three lumps after 2 m at a force of 0.83 Y R^2."""
    found = [along(tumbled(cube(EDGE), s), kind, 2.0, spin=spin, seed=s).roundness for s in range(3)]
    return float(np.median(found))


def _smoothed() -> tuple[float, float]:
    """Return the largest change of a radius over it under a membrane that lies on the upper part of a cube, and below that part."""
    lump = tumbled(cube(EDGE), 5)
    line, found, radii = 0.6 * lump.extent[1], lump.directions, lump.radii.copy()
    soft = Dough(1.0, tension=500.0).numbers()
    smooth(radii, lump.upward, found.neighbours, found.weights, line, lump.ball, soft)
    moved, under = np.abs(radii / lump.radii - 1), lump.radii * lump.upward > line
    return float(moved[under].max()), float(moved[~under].max())


def _of_the_seed() -> tuple[bool, bool]:
    one, same, other = (along(cube(EDGE, 100), "circle", 0.3, spin=0.5, seed=s) for s in (1, 1, 2))
    return np.array_equal(one.radii, same.radii), np.array_equal(one.radii, other.radii)


def _normality() -> tuple[float, float, float]:
    """Return mean, variance and fourth moment of many numbers of a row."""
    drawn = normals(3, 1000, 20_000)
    return float(drawn.mean()), float(drawn.var()), float((drawn**4).mean())


def _in_pieces(cuts: tuple[float, ...], heading: float) -> bool:
    """Whether a way in pieces leaves a lump just as the whole way does."""
    start, way = tumbled(cube(EDGE, 100), 2), 0.137 * np.array([math.cos(heading), math.sin(heading)])
    options: dict[str, Any] = {"weight": WEIGHT, "spin": 0.05, "seed": 2}
    whole, _ = start.rolled(tuple(way), 1.2, DOUGH, **options)
    pieces = start
    for part in np.diff([0.0, *cuts, 1.0]):
        pieces, _ = pieces.rolled(tuple(part * way), 1.2, DOUGH, **options)
    same = np.array_equal(pieces.radii, whole.radii) and np.array_equal(pieces.quaternion, whole.quaternion)
    return same and pieces.steps == whole.steps and abs(pieces.x - whole.x) + abs(pieces.y - whole.y) < 2e-15


def _slopes(count: int) -> tuple[float, float]:
    """Return how far off the squared slope of a coordinate over the sphere, and its Laplacian, are at most."""
    found = directions(count)
    slope = laplacian = 0.0
    for axis in range(3):
        values = found.vectors[:, axis]
        parts = np.einsum("nkc,nk->nc", found.weights, values[found.neighbours] - values[:, None])
        slope = max(slope, float(np.abs(np.hypot(parts[:, 0], parts[:, 1]) ** 2 - (1 - values**2)).max()))
        laplacian = max(laplacian, float(np.abs(parts[:, 2] + 2 * values).max()))
    return slope * count, laplacian * math.sqrt(count)


def _six_degrees() -> list[float]:
    """Return steps, heights, way over the ball, and turn in steps, after three steps and a half."""
    lump = cube(EDGE, 100)
    rolled, steps = lump.rolled((2 * lump.ball * STEP * 3.5, 0.0), 1.0, None)
    turn = 2 * math.acos(abs(rolled.quaternion[0]))
    return [rolled.steps, len(steps.heights), rolled.x / lump.ball / STEP, turn / STEP]


NONSENSE: dict[str, tuple[Any, Refusal]] = {
    "pressed flatter than it can be": (lambda: cube(EDGE).flattened(0.02), Refusal(NoEquilibrium)),
    "pressed by less than nothing": (lambda: cube(EDGE).flattened(-1e-3), Refusal(InvalidInput)),
    "pressed by no number": (lambda: cube(EDGE).flattened(math.nan), Refusal(InvalidInput)),
    "a cube of no size": (partial(cube, math.nan), Refusal(InvalidInput)),
    "a cube of less than no size": (partial(cube, -EDGE), Refusal(InvalidInput)),
    "a cube without end": (partial(cube, math.inf), Refusal(InvalidInput)),
    "ten directions": (partial(cube, EDGE, 10), Refusal(InvalidInput)),
    "yields at 0 Pa": (partial(Dough, 0.0), Refusal(InvalidInput)),
    "yields at no number": (partial(Dough, math.nan), Refusal(InvalidInput)),
    "a friction of 2": (partial(Dough, 5e3, friction=2.0), Refusal(InvalidInput)),
}
WHOLE = Check("heights finite, volume within 1e-12, radii 0.04 to 3 of the ball's", _whole)

CASES: tuple[Hard, ...] = (
    *group(
        "dough that is pressed out on one side comes out on another, at any force, yield, step, spin and resolution",
        {f"rolled, {name}": (partial(_rolled, options), WHOLE) for name, options in ROLLED.items()},
    ),
    *group(
        "errors of thousands of revolutions add up",
        {
            "a thousand revolutions": (partial(_revolved, 20), Value([0.0] * 3, abs=1e-12)),
            "ten thousand revolutions": (partial(_revolved, 200), Value([0.0] * 3, abs=1e-12)),
            "a step is six degrees": (_six_degrees, Value([3, 3, 3.5, 3.0], rel=1e-8)),
        },
        {
            f"a way in {len(cuts) + 1} pieces": (partial(_in_pieces, cuts, heading), Value(True))
            for cuts, heading in (
                ((0.5,), 0.3),
                ((0.01, 0.02, 0.5, 0.99), -2.0),
                (tuple(k / 12 for k in range(1, 12)), 2.9),
            )
        },
        {
            "chance is that of the seed": (_of_the_seed, Value((True, False))),
            "chance is that of the place in a row": (
                lambda: [*normals(7, 0, 4), *normals(7, 2, 2)],
                Value([0.75331618, 0.67812846, -0.02071717, 0.94110652, -0.02071717, 0.94110652], abs=1e-8),
            ),
            "chance is normal": (_normality, Value((0.0, 1.0, 3.0), abs=0.1)),
        },
        costly=("ten thousand revolutions",),
    ),
    *group(
        "a press takes off the height that it should, of a cube and of a round lump, be it hardly anything or nearly half",
        {
            f"a press of {1e3 * lost:g} mm after {travel:g} m": (
                partial(_lost, travel, lost),
                Value((1.0, 1.0), abs=2e-3),
            )
            for travel in (0.0, 0.3, 2.0)
            for lost in (1e-5, 1e-4, 1e-3, 5e-3, 1e-2)
        },
    ),
    *group(
        "a lump that does not flow turns, and keeps its shape",
        {
            "rigid": (partial(_kept, None), Value((0.0, True), abs=1e-12)),
            "far from its yield": (partial(_kept, Dough(1e9, 1e10)), Value((0.0, True), abs=1e-12)),
        },
    ),
    *group(
        "a membrane smooths the part that it lies on, and no edge beside it",
        {
            "dough that hardly yields under a tense membrane": (
                _smoothed,
                Check("above the line alone", lambda m: m[0] > 1e-3 and m[1] == 0),
            )
        },
    ),
    *group(
        "the axis of a lump's turns depends on the path and on chance; the known medians are of 30 lumps by a separate code",
        {
            f"rounded on {'a circle' if kind == 'circle' else 'an eight'}, spin {spin:g}": (
                partial(_rounded, kind, spin),
                Value(known, abs=0.012),
            )
            for kind, spin, known in (
                ("circle", 0.0, 0.098),
                ("circle", 0.1, 0.094),
                ("eight", 0.0, 0.043),
                ("eight", 0.1, 0.043),
            )
        },
    ),
    *group(
        "directions have no grid to take differences on",
        {
            f"derivatives over {count} directions": (
                partial(_slopes, count),
                Check("off by the square of their spacing", lambda off: off[0] < 30 and off[1] < 2),
            )
            for count in (100, 500, 2000)
        },
        {
            "a cube": (
                lambda: (volume(cube(EDGE)) / EDGE**3, cube(EDGE).height / EDGE, cube(EDGE).roundness / 0.125),
                Value((1.0, 1.0, 1.0), abs=0.016),
            ),
        },
    ),
    *group("numbers that make no lump, no press or no dough", NONSENSE),
)
