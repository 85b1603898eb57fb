"""Size of a contact: the diameter of flat cylinders by each shape that is fitted."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.perception.measure import CYLINDERS, NOISES, clouds, job, words
from stretch_bt.accuracy.perception.view import BodyPress
from stretch_bt.accuracy.points import Setting
from stretch_bt.perception import ContactSize, measure_contact, segment
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

__all__ = ["jobs"]

_SHAPES = ("auto", "circle", "ellipse", "free_form")
_DEFAULT = "auto"


def jobs(frames: int) -> Iterator[Job]:
    """Yield the root mean square error of the diameter along j, m; the stretch is known, the labels are ours."""
    presses = (CYLINDERS[1], *CYLINDERS[:1], *CYLINDERS[2:])
    for press, name in product(presses, ("white 0.5 mm", "correlated 1 mm, 8 frames")):
        for shape in _SHAPES:
            yield job(
                f"{words(press)}, {name}",
                Setting("contact size", shape),
                "diameter",
                frames,
                partial(_measured, press, shape),
                partial(_error, press),
                partial(_labelled, press, NOISES[name], frames),
                seconds=0.15,
                default=shape == _DEFAULT,
            )


def _labelled(press: BodyPress, noise: Any, count: int) -> Iterator[tuple[Any, Any]]:
    for points_, valid in clouds(press, noise, count):
        yield points_, segment(points_, valid)


def _measured(press: BodyPress, shape: str, points_: Any, labels: Any) -> ContactSize:
    return measure_contact(points_, labels, stretch=press.stretch, hypothesis=shape)


def _error(press: BodyPress, size: ContactSize) -> float:
    body = press.indenter
    assert isinstance(body, Cylinder)
    return float(size.diameter_j - body.diameter)
