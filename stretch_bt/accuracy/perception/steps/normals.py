"""Normals: the angle to those of the noise-free surface, over the width of the Gaussian."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.accuracy.perception.measure import CYLINDERS, NOISES, SPHERES, frames_of, run, words
from stretch_bt.accuracy.perception.noise import CLEAN
from stretch_bt.accuracy.perception.view import Seen, seen
from stretch_bt.accuracy.points import Point
from stretch_bt.perception import estimate_normals

__all__ = ["points"]

_KERNELS = (0.7e-3, 1.2e-3, 1.9e-3, 2.7e-3, 3.8e-3)
_TRUTH = 0.6e-3  # m; the narrowest Gaussian, which without noise needs no more


def points(quick: bool) -> Iterator[Point]:
    """Yield the root mean square angle, rad, on the deformed part of the sheet."""
    for press in (SPHERES + CYLINDERS)[: 1 if quick else None]:
        view = seen(press)
        truth, known = estimate_normals(*next(frames_of(view, CLEAN, True)), kernel=_TRUTH)
        for name in ("white 0.3 mm", "white 1 mm"):
            for kernel in _KERNELS:
                solve, error = partial(estimate_normals, kernel=kernel), partial(_angle, view, truth, known)
                answers = run(solve, error, frames_of(view, NOISES[name], quick))
                yield answers.point(f"{words(press)}, {name}", f"normals: kernel {kernel * 1e3:g} mm", "normal")


def _angle(view: Seen, truth: Any, known: Any, answer: tuple[Any, Any]) -> float:
    normals, trusted = answer
    where = trusted & known & (view.depth > 0) & (view.depth < view.depth.max() - 1e-3)
    cosine = np.clip((normals[where] * truth[where]).sum(axis=-1), -1.0, 1.0)
    return float(np.sqrt(np.mean(np.arccos(cosine) ** 2)))
