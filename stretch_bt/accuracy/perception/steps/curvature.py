"""Curvature on a sphere: the sum of the principal curvatures against 2 / R, over the width of the Gaussian."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product

import cv2
import numpy as np

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.perception.measure import NOISES, SPHERES, clouds, job, view_of, words
from stretch_bt.accuracy.perception.view import BodyPress
from stretch_bt.accuracy.points import Setting
from stretch_bt.perception import Curvatures, curvatures
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["jobs"]

_KERNELS = (1.2e-3, 1.9e-3, 2.7e-3, 3.8e-3)
_DEFAULT = 1.9e-3


def jobs(frames: int) -> Iterator[Job]:
    """Yield the root mean square error, 1/m, over the inner half of the contact."""
    for press, name in product(SPHERES, ("white 0.3 mm", "white 1 mm")):
        for kernel in _KERNELS:
            yield job(
                f"{words(press)}, {name}",
                Setting("curvature", f"kernel {kernel * 1e3:g} mm"),
                "curvature",
                frames,
                partial(curvatures, kernel=kernel),
                partial(_error, press),
                partial(clouds, press, NOISES[name], frames),
                default=kernel == _DEFAULT,
            )


def _error(press: BodyPress, found: Curvatures) -> float:
    body = press.indenter
    assert isinstance(body, Sphere)
    inside = cv2.distanceTransform(view_of(press).touching.astype(np.uint8), cv2.DIST_L2, 3)
    inner = inside > 0.5 * inside.max()
    return float(np.sqrt(np.mean((found.sum[inner & found.trusted] - 4.0 / body.diameter) ** 2)))
