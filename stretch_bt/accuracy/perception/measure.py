"""The parts that every step shares: its presses and noises, and root mean squares with medians of time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.perception.noise import CORRELATED, WHITE_03, WHITE_05, WHITE_10, Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, BodyPress, SheetView, seen
from stretch_bt.accuracy.points import REFERENCE, REFUSED, Answer, Setting
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.perception import deproject, to_membrane
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = [
    "CYLINDERS",
    "FULL",
    "NOISES",
    "QUICK",
    "SPHERES",
    "Answers",
    "bound_job",
    "cloud",
    "clouds",
    "frames",
    "job",
    "run",
    "view_of",
    "words",
]

NOISES = {
    "white 0.3 mm": WHITE_03,
    "white 0.5 mm": WHITE_05,
    "white 1 mm": WHITE_10,
    "correlated 1 mm, 8 frames": CORRELATED,
}
SPHERES = (
    BodyPress(Sphere(0.03), 0.0, 0.010, (0.002, -0.003)),
    BodyPress(Sphere(0.03), 0.03, 0.010, (0.002, -0.003)),
    BodyPress(Sphere(0.06), 0.03, 0.010, (-0.003, 0.002)),
)
CYLINDERS = tuple(
    BodyPress(Cylinder(d), x, z, (0.003, -0.004))
    for d, x, z in ((0.02, 0.0, 0.01), (0.02, 0.03, 0.01), (0.015, 0.06, 0.006))
)
QUICK, FULL = 4, 40  # frames of a press
_AVERAGED = 8.0  # frames with smooth noise in a mean; it costs as many times more

Array = npt.NDArray[Any]


class Answers(NamedTuple):
    """Errors of the frames that had an answer, CPU seconds of all, and how many had none, with a reason."""

    errors: list[float]
    seconds: list[float]
    refused: int
    reason: str

    def rows(self, kind: str, reference_error: float | None) -> list[Answer]:
        """Return their root mean square and median time; the reason says how many were refused."""
        seconds, count = float(np.median(self.seconds)), len(self.seconds)
        reason = f"{self.refused} of {count} frames refused: {self.reason}" if self.refused else None
        if not self.errors:
            return [Answer(kind, None, seconds, reference_error, status=REFUSED, reason=reason)]
        error = float(np.sqrt(np.mean(np.square(self.errors))))
        return [Answer(kind, error, seconds, reference_error, reason=reason)]


def job(
    case: str,
    setting: Setting,
    kind: str,
    frames: int,
    solve: Callable[..., Any],
    error: Callable[[Any], float],
    inputs: Callable[[], Iterable[tuple[Any, ...]]],
    *,
    seconds: float = 0.03,
    default: bool = False,
    reference_error: float | None = None,
) -> Job:
    """Return the job of a step on some frames; `seconds` is CPU time of one, with its making."""

    def rows() -> list[Answer]:
        return run(solve, error, inputs()).rows(kind, reference_error)

    smooth = _AVERAGED if "correlated" in case else 1.0
    return Job(f"{case}, {frames} frames", setting, kind, frames * (seconds + 0.02 * smooth), rows, default=default)


def bound_job(case: str, frames: int, kind: str, bound: Callable[[], float]) -> Job:
    """Return the job of the least error that an unbiased estimator can have."""
    setting = Setting("Cramer-Rao bound", "")
    return Job(f"{case}, {frames} frames", setting, kind, 0.1, lambda: [Answer(kind, bound(), None, status=REFERENCE)])


@lru_cache(maxsize=8)
def view_of(press: BodyPress) -> SheetView:
    """Return the camera's view of a press."""
    return seen(press)


def words(press: BodyPress) -> str:
    """Return a press in words."""
    body = press.indenter
    assert isinstance(body, Sphere | Cylinder)
    name = type(body).__name__.lower()
    return f"{name} {body.diameter * 1e3:g} mm, stretch {press.stretch * 1e3:g} mm, depth {press.depth * 1e3:g} mm"


def frames(press: BodyPress, noise: Noise, count: int) -> Iterator[tuple[DepthFrame]]:
    """Yield some frames of a press."""
    return ((observe(view_of(press), noise, seed),) for seed in range(count))


def clouds(press: BodyPress, noise: Noise, count: int) -> Iterator[tuple[Array, npt.NDArray[np.bool_]]]:
    """Yield points (h, w, 3), m, membrane frame, and where they are valid, of some frames of a press."""
    return (cloud(view_of(press), noise, seed) for seed in range(count))


def cloud(view: SheetView, noise: Noise, seed: int) -> tuple[Array, npt.NDArray[np.bool_]]:
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
