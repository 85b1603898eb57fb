"""Outlines and their circularity: too few vertices, no area, another unit, and regions that are cut off or in pieces."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.hardcases.expect import Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.perception import circularity, outline_of

TURN = 2 * np.pi * np.arange(200) / 200
DISC = 0.0125 * np.column_stack([np.cos(TURN), np.sin(TURN)])
V, U = np.mgrid[:80, :80]
LABELS = np.where(np.hypot(U - 40.2, V - 39.7) < 25, 2, 0).astype(np.uint8)
PITCH = 0.4e-3


def labelled(*changes: tuple[Any, int]) -> npt.NDArray[np.uint8]:
    """Return labels of a disc, changed at each place to a label, in turn."""
    labels = LABELS.copy()
    for place, label in changes:
        labels[place] = label
    return labels


def scattered(points: Any, where: Any, value: float) -> npt.NDArray[np.float64]:
    """Return points of which some have another value."""
    out = np.array(points, dtype=float)
    out[where] = value
    return out


def round_within(tolerance: float) -> Value:
    """Expect a circularity of 1."""
    return Value(1.0, abs=tolerance, of=float)


CASES = (
    *group(
        "a circle stays one wherever it lies, in whatever unit and type its vertices come",
        {
            "disc": (lambda: circularity(DISC), round_within(0.002)),
            "disc at 1e6 mm": (lambda: circularity(DISC + [1e3, -1e3]), round_within(0.002)),
            "disc in float32": (lambda: circularity(DISC.astype(np.float32)), round_within(0.002)),
            "disc in millimetres": (lambda: circularity(DISC * 1e3), round_within(0.002)),
            "every vertex twice": (lambda: circularity(np.repeat(DISC, 2, axis=0)), round_within(0.002)),
            "in whole pixels": (lambda: circularity(np.round(DISC / PITCH).astype(int)), round_within(0.02)),
        },
        prefix="outline, ",
    ),
    *group(
        "too few vertices, or none that span an area",
        {
            "three points": (
                lambda: circularity(DISC[[0, 67, 133]]),
                Value(np.pi * np.sqrt(3) / 9, abs=1e-3, of=float),
            ),
            "empty": (lambda: circularity(np.zeros((0, 2))), Refusal(IllConditioned, "three vertices")),
            "one point": (lambda: circularity(DISC[:1]), Refusal(IllConditioned, "three vertices")),
            "all points one": (lambda: circularity(np.ones((50, 2))), Refusal(IllConditioned, "no area")),
            "collinear": (
                lambda: circularity(np.outer(np.arange(50.0), [1.0, 2.0])),
                Refusal(IllConditioned, "no area"),
            ),
        },
        prefix="outline, ",
    ),
    *group(
        "an input that is no outline",
        {
            "NaN": (lambda: circularity(scattered(DISC, 3, np.nan)), Refusal(InvalidInput, "finite")),
            "infinite": (lambda: circularity(scattered(DISC, 3, np.inf)), Refusal(InvalidInput, "finite")),
            "(n, 3)": (lambda: circularity(np.zeros((50, 3))), Refusal(InvalidInput, "shape")),
            "text": (lambda: circularity(np.array([["a", "b"]] * 9)), Refusal(InvalidInput, "real numbers")),
        },
        prefix="outline, ",
    ),
    *group(
        "a region that is all, nothing, cut off, in pieces or full of holes has an outline that is not its own",
        {
            "disc": (lambda: outline_of(LABELS, PITCH).roundness().circularity, round_within(0.005)),
            "none": (lambda: outline_of(0 * LABELS, PITCH), Refusal(NoContact, "no pixel")),
            "all": (lambda: outline_of(0 * LABELS + 2, PITCH), Refusal(IllConditioned, "edge of the image")),
            "all invalid": (lambda: outline_of(0 * LABELS + 255, PITCH), Refusal(NoContact, "no pixel")),
            "one pixel": (
                lambda: outline_of(labelled((LABELS > 0, 0), ((40, 40), 2)), PITCH),
                Refusal(IllConditioned, "at least 40"),
            ),
            "cut by the edge": (
                lambda: outline_of(LABELS[:, 30:], PITCH),
                Refusal(IllConditioned, "edge of the image"),
            ),
            "two contacts": (
                lambda: outline_of(np.hstack([LABELS, LABELS]), PITCH),
                Refusal(IllConditioned, "2 pieces"),
            ),
            "border unseen": (lambda: outline_of(labelled((V > 45, 255)), PITCH), Refusal(IllConditioned, "no depth")),
            "half of it dropped out": (
                lambda: outline_of(labelled(((U * 7 + V * 13) % 2 == 0, 255)), PITCH).roundness().circularity,
                round_within(0.05),
            ),
            "depth instead of labels": (
                lambda: outline_of(LABELS.astype(float), PITCH),
                Refusal(InvalidInput, "uint8"),
            ),
            "points of another image": (
                lambda: outline_of(LABELS, np.zeros((40, 80, 3))),
                Refusal(InvalidInput, "shape"),
            ),
            "points not known": (
                lambda: outline_of(LABELS, np.full((80, 80, 3), np.nan)),
                Refusal(NoContact, "no pixel"),
            ),
        },
        prefix="region, ",
    ),
)
