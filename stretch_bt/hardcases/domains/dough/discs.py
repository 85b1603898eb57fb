"""Lumps that are pressed to a disc: hardly, hard, cracked, round and square."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.expect import Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception import circularity
from stretch_bt.simulation.dough.disc import cracked, disc_force, edge_roughness, outline, thickness
from stretch_bt.simulation.dough.lump import Lump, cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.surface import disc_side, upper_side
from stretch_bt.simulation.membrane.press import press

EDGE = 0.025
DOUGH = Dough(5e3)
ANGLES = np.linspace(0, 2 * np.pi, 180, endpoint=False)


def _ball(radius: float = 0.0155) -> Lump:
    return Lump(np.full(500, radius), np.array([1.0, 0.0, 0.0, 0.0]), 4 / 3 * math.pi * radius**3)


def _borne(force: float, friction: float) -> float:
    """Return the force of a disc over the one that made it so thin."""
    dough = Dough(5e3, friction=friction)
    return disc_force(EDGE**3, thickness(EDGE**3, force, dough), dough) / force


def _area() -> float:
    """Return the area of an outline over the volume divided by the thickness."""
    x, y = outline(cube(EDGE), 8e-3, 720).T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2 / (EDGE**3 / 8e-3))


def _cracks() -> tuple[float, float]:
    """Return the relative deviation of cracked edges over 1.5 %, and their correlation over 3 mm of edge."""
    around = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    smooth = 0.025 * np.column_stack([np.cos(around), np.sin(around)])
    parts = np.array([np.hypot(*cracked(smooth, 0.015, 3e-3, seed).T) / 0.025 - 1 for seed in range(40)])
    lag = round(3e-3 / (2 * np.pi * 0.025) * 2000)
    return float(parts.std() / 0.015), float(np.mean(parts * np.roll(parts, lag, axis=1)) / parts.var())


def _repeated() -> tuple[bool, bool]:
    smooth = _oval(0.0)
    same = np.array_equal(cracked(smooth, 0.015, 3e-3, 1), cracked(smooth, 0.015, 3e-3, 1))
    return same, np.array_equal(cracked(smooth, 0.0, 3e-3, 1), smooth)


def _oval(part: float, radius: float = 0.018) -> Any:
    reach = radius * (1 + part * np.cos(2 * ANGLES))
    return np.column_stack([reach * np.cos(ANGLES), reach * np.sin(ANGLES)])


def _side(part: float) -> list[float]:
    """Return height of the middle, m, the error of the half width, m, and both radii of the side of a disc, m."""
    side: Any = disc_side(_oval(part), 0.014, 0.0155)
    middle = side.heights.shape[0] // 2
    widest = np.argwhere(side.heights[middle] > 0)
    half = (widest.max() - widest.min()) * side.pitch / 2
    off = max(abs(half - 0.018 * (1 + part)) - 1.5 * side.pitch, 0.0)
    return [float(side.heights[middle, middle]), off, side.tip_radius, side.feature]


def _roughness() -> float:
    rough = _oval(0.0) * (1 + 0.02 * np.sqrt(2) * np.cos(20 * ANGLES))[:, None]
    return float(edge_roughness(rough))


def _upper(travel: float) -> float:
    """Return how much higher the upper side of a lump is than the lump over its centroid, m, after so many metres of rolling."""
    lump = cube(EDGE)
    for k in range(round(travel / 0.02)):
        lump, _ = lump.rolled((0.02 * math.cos(k), 0.02 * math.sin(k)), 1.0, Dough(5e3, 1e5))
    return float(upper_side(lump).heights.max() - lump.extent[1])


def _mirrored() -> float:
    """Return how far the upper side of a cube is off its mirror images, m."""
    heights = upper_side(cube(EDGE)).heights
    return float(max(np.abs(heights - heights[::-1]).max(), np.abs(heights - heights[:, ::-1]).max()))


CASES: tuple[Hard, ...] = (
    *group(
        "a disc without friction yields everywhere at once; with much of it, hardly in the middle",
        {
            f"a disc under {force:g} N, friction {friction:g}": (partial(_borne, force, friction), Value(1.0, rel=1e-9))
            for force in (1e-6, 0.3, 5.0, 1e3)
            for friction in (0.0, 0.5, 1.0)
        },
        {
            "the force of a disc of 25 mm": (
                partial(disc_force, math.pi * 0.025**2 * 8e-3, 8e-3, DOUGH),
                Value(9.82 * 1.6, rel=0.01),
            ),
        },
    ),
    *group(
        "an outline comes from a ball or a cube, or is cracked",
        {
            "the area of an outline": (_area, Value(1.0, abs=2e-3)),
            "the outline of a ball": (
                partial(outline, _ball(), 8e-3),
                Range(0.998, 1.0, of=lambda o: float(circularity(o))),
            ),
            "the outline of a cube": (
                partial(outline, cube(EDGE), 8e-3),
                Value(0.85, abs=0.02, of=lambda o: float(circularity(o))),
            ),
            "cracks": (_cracks, Value((1.0, math.exp(-1)), abs=0.1)),
            "cracks of a seed, and none": (_repeated, Value((True, True))),
            "the roughness of an oval": (lambda: float(edge_roughness(_oval(0.1))), Value(0.0, abs=1e-3)),
            "the roughness of harmonics": (_roughness, Value(0.02, rel=1e-6)),
        },
        {
            f"the side of a disc, {100 * part:g} % oval": (
                partial(_side, part),
                Value([0.007, 0.0, 0.0155, 0.0155], abs=1e-9),
            )
            for part in (0.0, 0.1)
        },
    ),
    *group(
        "the upper side is drawn by angles, and looked up between them",
        {
            "the upper side of a cube": (partial(_upper, 0.0), Value(0.0, abs=5e-4)),
            "the upper side of a rolled lump": (partial(_upper, 0.6), Value(0.0, abs=1e-3)),
            "the upper side of a cube, mirrored": (_mirrored, Value(0.0, abs=1e-3)),
        },
        {
            "the upper side of a ball is that of a sphere": (
                lambda: press(upper_side(_ball()), 0.06, 3e-3).force / press("sphere:31mm", 0.06, 3e-3).force,
                Value(1.0, abs=0.01),
            ),
        },
    ),
    *group(
        "a disc of no force, no volume or no thickness, and cracks below 0",
        {
            "pressed by no force": (partial(thickness, EDGE**3, 0.0, DOUGH), Refusal(InvalidInput)),
            "no volume": (partial(thickness, math.nan, 1.0, DOUGH), Refusal(InvalidInput)),
            "no thickness": (partial(outline, cube(EDGE), 0.0), Refusal(InvalidInput)),
            "cracks below 0": (partial(cracked, np.zeros((4, 2)), -0.1, 1e-3), Refusal(InvalidInput)),
        },
    ),
)
