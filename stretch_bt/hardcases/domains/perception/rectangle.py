"""The fit of a rectangle and of a free outline, on a press of a box that the sheet solver made."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from stretch_bt.accuracy.perception.noise import WHITE_03, Noise, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.errors import InvalidInput, NoAnswer, NoContact
from stretch_bt.hardcases.expect import Check, Refusal
from stretch_bt.hardcases.hard import group
from stretch_bt.perception import deproject, to_membrane
from stretch_bt.perception.size.measure import measure_contact
from stretch_bt.simulation.membrane.indenters.box import Box

BOX = BodyPress(Box(14e-3, 22e-3, 0.4), 30e-3, 9e-3, (3e-3, -2e-3))
SIDES = 14e-3, 22e-3
EXACT = Noise(quantum=4e-6, dropouts=0.0)
Change = Callable[[Any, Any], tuple[Any, Any]]


@cache
def _frame(noise: Noise) -> tuple[Any, Any]:
    """Return points in the membrane frame and labels of the press."""
    view = seen(BOX)
    points, valid = deproject(observe(view, noise, 1))
    points = to_membrane(points, 0.2)
    face = view.touching | (points[..., 2] > 8.8e-3)
    return points, np.where(valid, np.where(face, 2, 1), 255).astype(np.uint8)


def _measured(change: Change | None = None, shape: str = "rectangle", noise: Noise = WHITE_03) -> Any:
    points, labels = (a.copy() for a in _frame(noise))
    points, labels = change(points, labels) if change else (points, labels)
    return measure_contact(points, labels, stretch=30e-3, hypothesis=shape)


def _or_reason(change: Change) -> Any:
    """Return the size, or the refusal with its reason."""
    try:
        return _measured(change)
    except NoAnswer as error:
        return error


def _right_or_refused(found: Any) -> bool:
    if isinstance(found, NoAnswer):
        return bool(found.reason)
    return bool((np.abs(np.subtract(found.sides, SIDES)) < 4.0 * np.array(found.sides_sd)).all())


def _right(size: Any) -> bool:
    errors = np.abs(np.subtract(size.sides, SIDES))
    stated = [*size.sides_sd, size.rotation_sd, size.diameter_i_sd, size.diameter_j_sd]
    return bool(
        (errors < 0.8e-3).all() and (errors < 3.0 * np.array(size.sides_sd)).all() and np.isfinite(stated).all()
    )


def _is(name: str) -> Check:
    return Check(f"a {name}", lambda size: size.shape == name)


def _without(where: Callable[[Any], Any]) -> Change:
    def change(points: Any, labels: Any) -> tuple[Any, Any]:
        labels[where(points)] = 255
        return points, labels

    return change


def _broken(points: Any, labels: Any) -> tuple[Any, Any]:
    rng = np.random.default_rng(0)
    hit = rng.random(labels.shape) < 0.2
    points[hit] = rng.choice([np.nan, np.inf, -np.inf], hit.sum())[:, None]
    labels[hit] = 255
    return points, labels


def _at_height(height: float) -> Change:
    def change(points: Any, labels: Any) -> tuple[Any, Any]:
        points[..., 2] = height
        return points, labels

    return change


A_THIRD = _without(lambda p: np.random.default_rng(1).random(p.shape[:2]) < 0.33)
A_QUARTER = _without(lambda p: (p[..., 0] > 3e-3) & (p[..., 1] > 0))
SIDES_RIGHT = Check("both sides within 0.8 mm and three of their finite deviations", _right)

CASES = (
    *group(
        "points that dropped out, are no numbers, or have single precision",
        {
            "exact": (partial(_measured, noise=EXACT), SIDES_RIGHT),
            "exact, chosen": (partial(_measured, noise=EXACT, shape="auto"), _is("rectangle")),
            "noisy, chosen": (partial(_measured, shape="auto"), _is("rectangle")),
            "float32": (partial(_measured, lambda p, v: (p.astype(np.float32), v)), SIDES_RIGHT),
            "NaN and infinite points": (partial(_measured, _broken), SIDES_RIGHT),
            "a third of the pixels dropped out": (partial(_measured, A_THIRD), SIDES_RIGHT),
            "a quarter of the frame gone": (
                partial(_or_reason, A_QUARTER),
                Check("sides within four of their deviations, or a reason", _right_or_refused),
            ),
        },
        prefix="rectangle, ",
    ),
    *group(
        "the labelled contact is none, or does not rise",
        {
            "concave": (partial(_measured, lambda p, v: (p * [1, 1, -1], v)), Refusal(NoContact, "rise")),
            "a plane called a contact": (partial(_measured, _at_height(0.0)), Refusal(NoContact, "rise")),
            "all at one height": (partial(_measured, _at_height(9e-3)), Refusal(NoAnswer, "contact")),
            "nothing in contact": (
                partial(_measured, lambda p, v: (p, np.minimum(v, 1))),
                Refusal(NoContact, "labelled"),
            ),
            "all invalid": (partial(_measured, lambda p, v: (p, np.full_like(v, 255))), Refusal(NoContact, "valid")),
            "free outline of nothing": (
                partial(_measured, _at_height(0.0), shape="free_form"),
                Refusal(NoContact, "rise"),
            ),
        },
        prefix="rectangle, ",
    ),
    *group(
        "an input has another unit, type or shape",
        {
            "millimetres": (partial(_measured, lambda p, v: (p * 1e3, v)), Refusal(InvalidInput, "metres")),
            "labels of another type": (
                partial(_measured, lambda p, v: (p, v.astype(int))),
                Refusal(InvalidInput, "uint8"),
            ),
            "points of another shape": (
                partial(_measured, lambda p, v: (p[..., :2], v)),
                Refusal(InvalidInput, r"\(h, w, 3\)"),
            ),
        },
        prefix="rectangle, ",
    ),
    *group(
        "an outline of free form follows noise, and this one has corners",
        {
            "free outline, exact": (
                partial(_measured, shape="free_form", noise=EXACT),
                Check(
                    "a free form, within 4 mm of the longer side",
                    lambda size: size.shape == "free_form" and abs(size.diameter_j - SIDES[1]) < 4e-3,
                ),
            ),
        },
        prefix="rectangle, ",
    ),
)
