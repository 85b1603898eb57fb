"""Size of a contact: the diameter of flat cylinders by each shape that is fitted."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from stretch_bt.accuracy.perception.measure import CYLINDERS, NOISES, frames_of, run, words
from stretch_bt.accuracy.perception.view import Seen, seen
from stretch_bt.accuracy.points import Point
from stretch_bt.perception import ContactSize, measure_contact, segment
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

__all__ = ["points"]

_SHAPES = ("circle", "ellipse", "free_form", "auto")


def points(quick: bool) -> Iterator[Point]:
    """Yield the root mean square error of the diameter along j, m; the stretch is known, the labels are ours."""
    for press in CYLINDERS[1 : 2 if quick else None] if quick else CYLINDERS:
        view = seen(press)
        for name in ("white 0.5 mm", "correlated 1 mm, 8 frames")[: 1 if quick else None]:
            for shape in _SHAPES:
                answers = run(
                    partial(_measured, view, shape), partial(_error, view), _labelled(view, NOISES[name], quick)
                )
                yield answers.point(f"{words(press)}, {name}", f"contact size: {shape}", "diameter")


def _labelled(view: Seen, noise: Any, quick: bool) -> Iterator[tuple[Any, Any]]:
    for points_, valid in frames_of(view, noise, quick):
        yield points_, segment(points_, valid)


def _measured(view: Seen, shape: str, points_: Any, labels: Any) -> ContactSize:
    return measure_contact(points_, labels, stretch=view.press.stretch, hypothesis=shape)


def _error(view: Seen, size: ContactSize) -> float:
    body = view.press.indenter
    assert isinstance(body, Cylinder)
    return float(size.diameter_j - body.diameter)
