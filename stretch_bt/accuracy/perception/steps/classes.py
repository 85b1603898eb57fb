"""Segmentation: how much of the contact is missed or made up, by each rule."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from stretch_bt.accuracy.perception.measure import CYLINDERS, NOISES, SPHERES, frames_of, run, words
from stretch_bt.accuracy.perception.view import Seen, seen
from stretch_bt.accuracy.points import Point
from stretch_bt.perception import segment
from stretch_bt.perception.segmentation import Rule
from stretch_bt.perception.types import CONTACT, INVALID

__all__ = ["points"]

_RULES: tuple[Rule, ...] = ("either", "mean")


def points(quick: bool) -> Iterator[Point]:
    """Yield one less the overlap of labels and truth: pixels in both over pixels in either."""
    for press in (SPHERES + CYLINDERS)[: 2 if quick else None]:
        view = seen(press)
        for name, noise in list(NOISES.items())[: 1 if quick else None]:
            for rule in _RULES:
                solve: Any = partial(segment, rule=rule)
                answers = run(solve, partial(_apart, view), frames_of(view, noise, quick))
                yield answers.point(f"{words(press)}, {name}", f"classes: rule {rule}", "overlap")


def _apart(view: Seen, labels: Any) -> float:
    found, seen_ = labels == CONTACT, labels != INVALID
    either = (found | view.touching) & seen_
    return 1.0 - float((found & view.touching).sum()) / max(float(either.sum()), 1.0)
