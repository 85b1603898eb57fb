"""Revolutions of a lump of dough, and the same with half of the step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from drifts.course import Course, Finding
from stretch_bt.accuracy.dough.rolling import path
from stretch_bt.perception import circularity
from stretch_bt.simulation.dough.disc import outline
from stretch_bt.simulation.dough.lump import STEP, Lump, Rolled, cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.objects.dough import DoughObject
from stretch_bt.simulation.scene import load_scene

PATHS = ("eight", "circle")
GROUP = 1.2  # force over the yield stress times the square of the ball's radius
MISSING, CHANGE = 1e-3, 0.01
_TURNS = 10  # revolutions in the end over which heights are averaged
_DISC = 0.35  # of the diameter of the ball: how thick a lump is pressed to see how round it is


class Shape(NamedTuple):
    """Mean radius of a lump, m, its mean height as it rolls, m, and the circularity of the discs that it is pressed to, in the mean of a revolution.

    How it lies at one moment is the sum of all its revolutions, so that a disc of that moment alone says little of its shape.
    """

    radius: float
    thickness: float
    circularity: float


class Rolling:
    """A lump on its way: what was missing of its volume in each step, and its last heights."""

    def __init__(self, kind: str, step: float, lump: Lump, dough: Dough, weight: float) -> None:
        self.step, self.lump, self.dough, self.weight = step, lump, dough, weight
        self.legs = cycle(path(kind).tolist())
        self.force = GROUP * dough.yield_stress * lump.ball**2
        self.turn = round(math.tau / step)
        self.largest, self.sum = 0.0, 0.0
        self.heights: list[npt.NDArray[np.float64]] = []

    def revolve(self, revolutions: int) -> None:
        """Roll on until it has made so many revolutions in all."""
        while self.lump.steps < self.turn * revolutions:
            steps = self._roll()
            missing = np.abs(steps.missing)
            self.largest, self.sum = max(self.largest, missing.max(initial=0.0)), self.sum + float(missing.sum())
            self.heights = [*self.heights[-self.turn * _TURNS :], steps.heights]

    def _roll(self) -> Rolled:
        x, y = next(self.legs)
        self.lump, steps = self.lump.rolled((x, y), self.force, self.dough, weight=self.weight, step=self.step)
        return steps

    def shape(self) -> Shape:
        """Return its shape now; it rolls on by a revolution."""
        radius, thickness = float(self.lump.radii.mean()), float(np.concatenate(self.heights).mean())
        first, round_ = self.lump.steps, []
        while self.lump.steps < first + self.turn:
            line = outline(self.lump, 2 * _DISC * self.lump.ball)
            round_.append(float(circularity(line)))
            self._roll()
        return Shape(radius, thickness, float(np.mean(round_)))


def revolutions(
    count: int, seed: int = 0, *, paths: Sequence[str] = PATHS, steps: tuple[float, float] = (STEP, STEP / 2)
) -> list[Finding]:
    """Roll the cube of the scene `dough_cube` by `count` revolutions on each path, and again with a finer step.

    There is no spin noise, of which a finer step would draw another. `seed` draws how the cube lies.
    """
    spec = load_scene("dough_cube").object
    assert isinstance(spec, DoughObject)
    dough, found = Dough(spec.yield_stress, spec.modulus), []
    heading = float(np.random.default_rng(seed).uniform(0, math.tau))
    for kind in paths:
        start = cube(spec.edge, spec.directions, heading)
        usual, finer = (Rolling(kind, step, start, dough, spec.weight) for step in steps)
        course = Course(count)
        for k in range(count):
            usual.revolve(k + 1)
            course.done(k + 1)
        finer.revolve(count)
        found += [
            Finding(f"{kind}: volume missing in a step, the largest part of it", usual.largest, MISSING),
            Finding(f"{kind}: its sum", usual.sum),
            *_changes(kind, usual.shape(), finer.shape()),
            *course.findings(),
        ]
    return found


def _changes(kind: str, usual: Shape, finer: Shape) -> list[Finding]:
    pairs = zip(Shape._fields, usual, finer, strict=True)
    return [Finding(f"{kind}: change of {name} with half of the step", abs(a / b - 1), CHANGE) for name, a, b in pairs]
