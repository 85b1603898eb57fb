"""What every step shares: the presses and noises it is measured on, and root mean squares with medians of time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.noise import CORRELATED, WHITE_03, WHITE_05, WHITE_10, Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, Press, Seen
from stretch_bt.accuracy.points import Point
from stretch_bt.errors import NoAnswer
from stretch_bt.perception import deproject, to_membrane
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["CYLINDERS", "FULL", "NOISES", "QUICK", "SPHERES", "Answers", "cloud", "frames_of", "run", "words"]

NOISES = {
    "white 0.3 mm": WHITE_03,
    "white 0.5 mm": WHITE_05,
    "white 1 mm": WHITE_10,
    "correlated 1 mm, 8 frames": CORRELATED,
}
SPHERES = (
    Press(Sphere(0.03), 0.0, 0.010, (0.002, -0.003)),
    Press(Sphere(0.03), 0.03, 0.010, (0.002, -0.003)),
    Press(Sphere(0.06), 0.03, 0.010, (-0.003, 0.002)),
)
CYLINDERS = tuple(
    Press(Cylinder(d), x, z, (0.003, -0.004))
    for d, x, z in ((0.02, 0.0, 0.01), (0.02, 0.03, 0.01), (0.015, 0.06, 0.006))
)
QUICK, FULL = 4, 40  # frames of a press

Array = npt.NDArray[Any]


class Answers(NamedTuple):
    """Errors of the frames that had an answer, CPU seconds of all, and how many had none, with a reason."""

    errors: list[float]
    seconds: list[float]
    refused: int
    reason: str

    def point(self, case: str, setting: str, kind: str) -> Point:
        """Return their root mean square and median time as a point."""
        seconds = float(np.median(self.seconds))
        if not self.errors:
            return Point(case, setting, kind, None, seconds, f"refused: {self.reason}")
        error = float(np.sqrt(np.mean(np.square(self.errors))))
        return Point(f"{case}, refused {self.refused}" if self.refused else case, setting, kind, error, seconds)


def words(press: Press) -> str:
    """Return a press in words."""
    body = press.indenter
    assert isinstance(body, Sphere | Cylinder)
    name = type(body).__name__.lower()
    return f"{name} {body.diameter * 1e3:g} mm, stretch {press.stretch * 1e3:g} mm, depth {press.depth * 1e3:g} mm"


def frames_of(view: Seen, noise: Noise, quick: bool) -> Iterator[tuple[Array, npt.NDArray[np.bool_]]]:
    """Yield points (h, w, 3), m, membrane frame, and where they are valid, of some frames of a press."""
    return (cloud(view, noise, seed) for seed in range(QUICK if quick else FULL))


def cloud(view: Seen, noise: Noise, seed: int) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Return points (h, w, 3), m, membrane frame, and where they are valid, of one frame of a press."""
    points, valid = deproject(observe(view, noise, seed))
    return to_membrane(points, PLANE_DISTANCE), valid


def run(solve: Callable[..., Any], error: Callable[[Any], float], inputs: Iterable[tuple[Any, ...]]) -> Answers:
    """Return the errors of the answers to some inputs, and the CPU time of each."""
    errors, seconds, refused, reason = [], [], 0, ""
    for arguments in inputs:
        began = time.process_time()
        try:
            answer = solve(*arguments)
        except NoAnswer as none:
            answer, refused, reason = None, refused + 1, none.reason
        seconds.append(time.process_time() - began)
        if answer is not None:
            errors.append(error(answer))
    return Answers(errors, seconds, refused, reason)
