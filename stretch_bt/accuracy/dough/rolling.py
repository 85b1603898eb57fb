"""Lumps that roll under a given force along a given path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.dough.lump import Lump, cube
from stretch_bt.simulation.dough.material import Dough

__all__ = ["path", "roll", "tumbled"]

Array = npt.NDArray[np.float64]

_DENSITY = 1250  # kg/m^3


def path(kind: str) -> Array:
    """Return the legs (k, 2), m, of a lap of the hand: a circle of 30 mm or a figure-eight of 45 mm."""
    t = np.linspace(0, 2 * np.pi, 49)
    circle = 0.030 * np.column_stack([np.cos(t), np.sin(t)])
    eight = 0.045 * np.column_stack([np.sin(t), 0.8 * np.sin(t) * np.cos(t)])
    return np.asarray(np.diff(circle if kind == "circle" else eight, axis=0))


def tumbled(edge: float, count: int, seed: int) -> Lump:
    """Return a cube of an edge, m, that lies as a seed says, its radius known in `count` directions."""
    turned = np.random.default_rng(seed).standard_normal(4)
    return replace(cube(edge, count), quaternion=turned / np.linalg.norm(turned))


def roll(
    lump: Lump, kind: str, marks: Sequence[float], dough: Dough, force: float, spin: float, seed: int
) -> tuple[list[float], Array, Lump]:
    """Return the roundness after each travel of `marks`, m, the height at each step, m, and the lump."""
    legs, done = path(kind), 0.0
    found: list[float] = []
    heights: list[Array] = []
    weight = _DENSITY * 9.81 * lump.volume
    for k in range(10**9):
        leg = legs[k % len(legs)]
        lump, steps = lump.rolled((leg[0], leg[1]), force, dough, weight=weight, spin=spin, seed=seed)
        heights.append(steps.heights)
        done += math.hypot(*leg)
        while len(found) < len(marks) and done >= marks[len(found)]:
            found.append(lump.roundness)
        if len(found) == len(marks):
            break
    return found, np.concatenate(heights), lump
