"""Circularity of outlines of 25 mm, with and without jitter, by each method."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from stretch_bt.accuracy.perception.measure import FULL, QUICK, run
from stretch_bt.accuracy.perception.outlines import PITCH, jittered, outline, true_circularity
from stretch_bt.accuracy.points import Point
from stretch_bt.perception import circularity
from stretch_bt.perception.outlines.roundness import Method

__all__ = ["points"]

_METHODS: tuple[Method, ...] = ("pixel_chain", "low_pass", "contour")


def points(quick: bool) -> Iterator[Point]:
    """Yield the root mean square error of 4 pi A / P^2."""
    for shape in ("disc", "oval", "square"):
        truth = true_circularity(shape)
        for jitter in (0.0, 1.0):
            outlines = [(jittered(outline(shape), jitter * PITCH, seed),) for seed in range(QUICK if quick else FULL)]
            for method in _METHODS:
                answers = run(partial(circularity, method=method), lambda c: c - truth, outlines)  # noqa: B023
                yield answers.point(f"{shape}, jitter {jitter:g} pixels", f"outline: {method}", "circularity")
