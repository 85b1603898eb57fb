"""Presses of the sheet, each started from the one before, with the same press again now and then."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from drifts.course import Course, Finding
from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.press import PressResult, press
from stretch_bt.simulation.membrane.sheet.settings import Settings

Array = npt.NDArray[np.float64]
Press = Callable[..., PressResult]

INDENTER, WITHIN = "sphere:20mm", 0.01
LOW, HIGH = np.array([0.010, 0.003, -0.020, -0.020]), np.array([0.060, 0.015, 0.020, 0.020])  # m: stretch, depth, place
STEP = 1e-3  # m, standard deviation of each of them from press to press, which is what the settings are for
FIXED = np.array([0.030, 0.008, 0.004, -0.006])
APART = 100  # presses from one at FIXED to the next


def walk(seed: int, apart: int = APART) -> Iterator[Array]:
    """Yield stretch, depth and place (4,), m, of presses: a random walk between LOW and HIGH, and FIXED in between."""
    chance, here, width = np.random.default_rng(seed), (LOW + HIGH) / 2, HIGH - LOW
    while True:
        for _ in range(apart - 1):
            far = np.mod(here + chance.normal(0.0, STEP, 4) - LOW, 2 * width)
            here = LOW + np.minimum(far, 2 * width - far)
            yield here
        yield FIXED


def presses(count: int, seed: int = 0, *, apart: int = APART, solve: Press = press) -> list[Finding]:
    """Press `count` times, and return how far forces at FIXED are off the first one there, and off one from flat."""
    settings = Settings.within(WITHIN)

    def pressed(load: Array, start: PressResult | None) -> PressResult:
        stretch, depth, x, y = load.tolist()
        return solve(INDENTER, stretch, depth, at=(x, y), settings=settings, start=start)

    cold = pressed(FIXED, None).force
    last, forces, refused = pressed(FIXED, None), [], 0
    loads, course = walk(seed, apart), Course(count)
    for k in range(count):
        load = next(loads)
        try:
            last = pressed(load, last)
            if load is FIXED:
                forces.append(last.force)
        except NoEquilibrium:
            refused += 1
        course.done(k + 1)
    found = np.array(forces)
    return [
        Finding("presses without an answer", refused, 0),
        Finding("presses at the fixed depth and place", len(found)),
        Finding(
            "their largest difference from the first, a part of it", float(np.abs(found / found[0] - 1).max()), WITHIN
        ),
        Finding("from a press that starts from flat", float(np.abs(found / cold - 1).max()), WITHIN),
        Finding("of the last such from the first such", abs(pressed(FIXED, None).force / cold - 1), 0),
        *course.findings(),
    ]
