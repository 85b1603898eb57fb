"""Height of the object's top, on labels that are right and on our own."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.accuracy.perception.measure import CYLINDERS, NOISES, SPHERES, cloud, frames_of, run, words
from stretch_bt.accuracy.perception.noise import CLEAN
from stretch_bt.accuracy.perception.view import Seen, seen
from stretch_bt.accuracy.points import REFERENCE, Point
from stretch_bt.perception import segment, track_height
from stretch_bt.perception.types import CONTACT, INVALID, UNDEFORMED
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.units import Estimate

__all__ = ["points"]


def points(quick: bool) -> Iterator[Point]:
    """Yield the root mean square error, m; for flat tops beside the Cramer-Rao bound of white noise."""
    for press in (SPHERES + CYLINDERS)[: 1 if quick else None] if not quick else (CYLINDERS[1],):
        view = seen(press)
        truth = _top(view)
        for name, noise in NOISES.items():
            case = f"{words(press)}, {name}"
            if noise.white > 0.0 and isinstance(press.indenter, Cylinder):
                bound = noise.white / float(np.sqrt(view.touching.sum()))
                yield Point(case, "height: Cramer-Rao bound", "height", bound, None, REFERENCE)
            for labels in (_true_labels, segment):
                setting = "height: true labels" if labels is _true_labels else "height: our labels"
                solve = partial(_height, view, labels)
                answers = run(solve, lambda e: e.value - truth, frames_of(view, noise, quick))  # noqa: B023
                yield answers.point(case, setting, "height")


def _height(view: Seen, labels: Any, points_: Any, valid: Any) -> Estimate:
    found = labels(view, valid) if labels is _true_labels else labels(points_, valid)
    return track_height(points_, valid, found)


def _true_labels(view: Seen, valid: Any) -> Any:
    return np.where(valid, np.where(view.touching, CONTACT, UNDEFORMED), INVALID).astype(np.uint8)


def _top(view: Seen) -> float:
    """Return the height of the sheet over the top, m: its contact is a little softer than a hard one."""
    points_, _ = cloud(view, CLEAN, 0)
    z = points_[..., 2][view.touching]
    return float(np.median(z)) if isinstance(view.press.indenter, Cylinder) else float(z.max())
