"""Normals: the angle to the normals of the noise-free surface, over the width of the Gaussian."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache, partial
from itertools import product
from typing import Any

import numpy as np

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.peers import guarded, open3d_normals
from stretch_bt.accuracy.perception.measure import CYLINDERS, NOISES, SPHERES, cloud, clouds, job, view_of, words
from stretch_bt.accuracy.perception.noise import CLEAN
from stretch_bt.accuracy.perception.view import BodyPress
from stretch_bt.accuracy.points import Setting
from stretch_bt.perception import estimate_normals

__all__ = ["jobs"]

_KERNELS = (0.7e-3, 1.2e-3, 1.9e-3, 2.7e-3, 3.8e-3)
_DEFAULT = 1.9e-3
_TRUTH = 0.6e-3  # m; the narrowest Gaussian, which without noise needs no more


def jobs(frames: int) -> Iterator[Job]:
    """Yield the root mean square angle, rad, on the deformed part of the sheet."""
    for press, name in product(SPHERES + CYLINDERS, ("white 0.3 mm", "white 1 mm")):
        case, inputs, error = (
            f"{words(press)}, {name}",
            partial(clouds, press, NOISES[name], frames),
            partial(_angle, press),
        )
        for kernel in _KERNELS:
            setting, solve = Setting("normals", f"kernel {kernel * 1e3:g} mm"), partial(estimate_normals, kernel=kernel)
            yield job(case, setting, "normal", frames, solve, error, inputs, default=kernel == _DEFAULT)
        for radius in open3d_normals.RADII:
            setting, solve = Setting(open3d_normals.NAME, f"radius {radius * 1e3:g} mm"), partial(_open3d, radius)
            yield guarded("open3d_normals", job(case, setting, "normal", frames, solve, error, inputs, seconds=0.5))


def _open3d(radius: float, points_: Any, valid: Any) -> tuple[Any, Any]:
    return open3d_normals.normals(points_, valid, radius), valid


@lru_cache(maxsize=8)
def _truth(press: BodyPress) -> tuple[Any, Any]:
    return estimate_normals(*cloud(view_of(press), CLEAN, 0), kernel=_TRUTH)


def _angle(press: BodyPress, answer: tuple[Any, Any]) -> float:
    (normals, trusted), (truth, known), depth = answer, _truth(press), view_of(press).depth
    where = trusted & known & (depth > 0) & (depth < depth.max() - 1e-3)
    cosine = np.clip((normals[where] * truth[where]).sum(axis=-1), -1.0, 1.0)
    return float(np.sqrt(np.mean(np.arccos(cosine) ** 2)))
