"""Curvature on a sphere: the sum of the principal curvatures against 2 / R, over the width of the Gaussian."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import cv2
import numpy as np

from stretch_bt.accuracy.perception.measure import NOISES, SPHERES, frames_of, run, words
from stretch_bt.accuracy.perception.view import Seen, seen
from stretch_bt.accuracy.points import Point
from stretch_bt.perception import Curvatures, curvatures
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["points"]

_KERNELS = (1.2e-3, 1.9e-3, 2.7e-3, 3.8e-3)


def points(quick: bool) -> Iterator[Point]:
    """Yield the root mean square error, 1/m, over the inner half of the contact."""
    for press in SPHERES[: 1 if quick else None]:
        view = seen(press)
        for name in ("white 0.3 mm", "white 1 mm"):
            for kernel in _KERNELS:
                answers = run(
                    partial(curvatures, kernel=kernel), partial(_error, view), frames_of(view, NOISES[name], quick)
                )
                yield answers.point(f"{words(press)}, {name}", f"curvature: kernel {kernel * 1e3:g} mm", "curvature")


def _error(view: Seen, found: Curvatures) -> float:
    body = view.press.indenter
    assert isinstance(body, Sphere)
    inside = cv2.distanceTransform(view.touching.astype(np.uint8), cv2.DIST_L2, 3)
    inner = inside > 0.5 * inside.max()
    return float(np.sqrt(np.mean((found.sum[inner & found.trusted] - 4.0 / body.diameter) ** 2)))
