"""Segmentation: how much of the contact is missed or made up, by each rule."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.perception.measure import CYLINDERS, NOISES, SPHERES, clouds, job, view_of, words
from stretch_bt.accuracy.perception.view import BodyPress
from stretch_bt.accuracy.points import Setting
from stretch_bt.perception import segment
from stretch_bt.perception.segmentation import Rule
from stretch_bt.perception.types import CONTACT, INVALID

__all__ = ["jobs"]

_RULES: tuple[Rule, ...] = ("mean", "either")
_DEFAULT = "mean"


def jobs(frames: int) -> Iterator[Job]:
    """Yield one less the overlap of labels and truth: pixels in both over pixels in either."""
    for press, (name, noise) in product(SPHERES + CYLINDERS, NOISES.items()):
        for rule in _RULES:
            solve: Any = partial(segment, rule=rule)
            yield job(
                f"{words(press)}, {name}",
                Setting("segmentation", f"rule {rule}"),
                "overlap",
                frames,
                solve,
                partial(_apart, press),
                partial(clouds, press, noise, frames),
                default=rule == _DEFAULT,
            )


def _apart(press: BodyPress, labels: Any) -> float:
    touching, found, visible = view_of(press).touching, labels == CONTACT, labels != INVALID
    either = (found | touching) & visible
    return 1.0 - float((found & touching).sum()) / max(float(either.sum()), 1.0)
