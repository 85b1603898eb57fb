"""Circularity of outlines of 25 mm, with and without jitter, by each method."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.perception.measure import job
from stretch_bt.accuracy.perception.outlines import PITCH, jittered, outline, true_circularity
from stretch_bt.accuracy.points import Setting
from stretch_bt.perception import circularity
from stretch_bt.perception.outlines.roundness import Method

__all__ = ["jobs"]

_METHODS: tuple[Method, ...] = ("contour", "low_pass", "pixel_chain")
_DEFAULT = "contour"


def jobs(frames: int) -> Iterator[Job]:
    """Yield the root mean square error of 4 pi A / P^2."""
    for jitter, shape in product((1.0, 0.0), ("disc", "oval", "square")):
        truth = true_circularity(shape)
        for method in _METHODS:
            yield job(
                f"{shape}, jitter {jitter:g} pixels",
                Setting("circularity", method),
                "circularity",
                frames,
                partial(circularity, method=method),
                partial(_off, truth),
                partial(_outlines, shape, jitter, frames),
                seconds=0.0,
                default=method == _DEFAULT,
                reference_error=0.0,
            )


def _off(truth: float, found: float) -> float:
    return found - truth


def _outlines(shape: str, jitter: float, count: int) -> Iterator[tuple[Any]]:
    return ((jittered(outline(shape), jitter * PITCH, seed),) for seed in range(count))
