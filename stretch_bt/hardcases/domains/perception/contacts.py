"""Segmentation and the contact: too little depth, no contact, several, or one that is cut off."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.hardcases.domains.perception.pressed_frames import (
    DISTANCE,
    EDGE,
    FLAT,
    SATURATED,
    W,
    cloud,
    correlated,
    frame,
    half_gone,
    labels,
    one_pixel,
    pixel_places,
    press,
    with_pixels,
)
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.perception import classify, curvatures, estimate_normals, find_contact, segment
from stretch_bt.perception.types import CONTACT, DEFORMED, INVALID, UNDEFORMED

NAN, INF = float("nan"), float("inf")
SMALL = 15e-3 * float(np.sin(0.5))


def all_are(label: int) -> Check:
    """Expect one label everywhere."""
    return Check(f"label {label} everywhere", lambda found: (found == label).all())


def covers(*places: tuple[float, float, float], least: float = 0.9) -> Check:
    """Expect contact in the discs (x, y, radius), m, and nowhere else."""

    def check(found: Any) -> bool:
        x, y = pixel_places()
        inside = np.any([np.hypot(x - a, y - b) < 0.7 * r for a, b, r in places], axis=0)
        near = np.any([np.hypot(x - a, y - b) < 1.5 * r for a, b, r in places], axis=0)
        seen = found != INVALID
        return bool((found[inside & seen] == CONTACT).mean() > least and not (found[~near] == CONTACT).any())

    return Check(f"contact over {least:.0%} of each face and none far from it", check)


def _as_any(given: Any) -> Any:
    return given


def _unsure(found: Any) -> bool:
    raised = found.labels == DEFORMED
    sure = (found.labels == CONTACT).any()
    return bool(not sure and raised.any() and (found.confidence[raised] < 0.7).mean() > 0.9)


FACE = covers((0.0, 0.0, EDGE))
HALF = covers((0.0, 0.0, EDGE), least=0.3)

CASES = (
    *group(
        "labels are judged by neighbours, a plane and a noise that may all be missing or broken",
        {
            "empty image": (lambda: segment(np.zeros((0, 0, 3)), np.zeros((0, 0), bool)).shape, Value((0, 0))),
            "all invalid": (lambda: labels(0 * FLAT), all_are(INVALID)),
            "one valid pixel": (lambda: labels(one_pixel())[80, 100], Value(UNDEFORMED)),
            "constant depth": (lambda: labels(FLAT), all_are(UNDEFORMED)),
            "one row": (
                lambda: labels(with_pixels(0 * FLAT, {(80, u): DISTANCE for u in range(W)}))[80],
                all_are(UNDEFORMED),
            ),
            "half dropped out": (lambda: labels(half_gone()), HALF),
            "saturated pixels": (
                lambda: labels(with_pixels(press(), {(80, 90): SATURATED, (20, 30): SATURATED})),
                FACE,
            ),
            "NaN and inf": (
                lambda: labels(with_pixels(press(), {(80, 100): NAN, (79, 100): INF, (81, 100): -INF})),
                FACE,
            ),
            "float64 as float32": (
                lambda: (labels(press().astype(np.float64)) == labels(press())).mean(),
                Check("at most one pixel in a thousand differs", lambda alike: alike > 0.999),
            ),
            "wrong shape": (lambda: segment(FLAT, FLAT > 0), Refusal(InvalidInput, r"\(h, w, 3\) floats")),
            "mask of numbers": (
                lambda: segment(np.zeros((4, 4, 3)), _as_any(np.ones((4, 4)))),
                Refusal(InvalidInput, "bool mask"),
            ),
        },
        prefix="segment, ",
    ),
    *group(
        "the contact is not one round patch in the middle of the image, or there is none",
        {
            "two contacts": (
                lambda: labels(press(x0=-22e-3, radius=15e-3) + press(x0=22e-3, radius=15e-3, noise=0.0) - FLAT),
                covers((-22e-3, 0.0, SMALL), (22e-3, 0.0, SMALL), least=0.8),
            ),
            "concave": (lambda: (labels(2 * FLAT - press()) == CONTACT).any(), Value(False)),
            "cap cut by the frame's edge": (lambda: labels(press(x0=42e-3)), covers((42e-3, 0.0, EDGE), least=0.6)),
            "contact at the clamp": (lambda: labels(press(y0=28e-3)), covers((0.0, 28e-3, EDGE), least=0.8)),
            "correlated noise": (
                lambda: classify(*cloud(press(radius=15e-3, angle=0.25, noise=0.0) + correlated())),
                Check("raised, and undecided rather than certain of a contact", _unsure),
            ),
        },
        prefix="segment, ",
    ),
    *group(
        "nothing has depth, and so nothing has a direction or a bend",
        {
            "normals, all invalid": (
                lambda: estimate_normals(*cloud(0 * FLAT)),
                Check("no normal is trusted", lambda found: not found[1].any()),
            ),
            "curvatures, all invalid": (
                lambda: curvatures(*cloud(0 * FLAT)),
                Check(
                    "no curvature is trusted, and none is given",
                    lambda found: not found.trusted.any() and not found.sum.any(),
                ),
            ),
        },
    ),
    *group(
        "a frame may show no contact, or none that can be recognised",
        {
            "all invalid": (
                lambda: find_contact(frame(0 * FLAT)),
                Refusal(NoContact, "no pixel of the frame has depth"),
            ),
            "one valid pixel": (
                lambda: find_contact(frame(one_pixel())),
                Refusal(NoContact, "no part of the membrane"),
            ),
            "constant depth": (lambda: find_contact(frame(FLAT)), Refusal(NoContact, "no part of the membrane")),
            "no plane": (
                lambda: find_contact(dataclasses.replace(frame(FLAT), plane_distance=None)),
                Refusal(InvalidInput, "plane_distance"),
            ),
            "concave": (lambda: find_contact(frame(2 * FLAT - press())), Refusal(NoContact, "no part of the membrane")),
            "half dropped out": (lambda: find_contact(frame(half_gone())).labels, HALF),
        },
        prefix="contact, ",
    ),
)
