"""Heights and first contact: a tracked top may vanish, and compared frames may not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.hardcases.domains.perception.pressed_frames import (
    FLAT,
    SATURATED,
    TOP,
    H,
    W,
    cloud,
    half_gone,
    one_pixel,
    press,
    still,
    with_pixels,
)
from stretch_bt.hardcases.expect import Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.perception import ContactDetector, HeightTracker, segment, track_height
from stretch_bt.perception.types import CONTACT


def _height(depth: Any) -> Any:
    points, valid = cloud(depth)
    return track_height(points, valid, segment(points, valid))


def _followed(make: Callable[[], Any], *images: Any) -> list[Any]:
    follower = make()
    return [follower.update(image) for image in images]


CASES = (
    *group(
        "the top has few pixels, and they may be missing or saturated",
        {
            "all invalid": (lambda: _height(0 * FLAT), Refusal(NoContact, "no pixel in contact has depth")),
            "no contact": (lambda: _height(FLAT), Refusal(NoContact, "no pixel in contact has depth")),
            "half dropped out": (lambda: _height(half_gone()), Value(TOP, abs=0.1e-3, of=float)),
            "saturated pixels": (
                lambda: _height(with_pixels(press(), {(80, 90): SATURATED, (79, 99): SATURATED})),
                Value(TOP, abs=0.05e-3, of=float),
            ),
            "one point": (
                lambda: track_height(*cloud(one_pixel()), np.full((H, W), CONTACT, np.uint8)),
                Refusal(IllConditioned, "twelve"),
            ),
            "labels of another resolution": (
                lambda: track_height(*cloud(FLAT), np.zeros((H, W // 2), np.uint8)),
                Refusal(InvalidInput, "labels need the shape"),
            ),
        },
        prefix="height, ",
    ),
    *group(
        "each frame is compared with the first ones, which it may not fit",
        {
            "all invalid": (
                lambda: _followed(HeightTracker, FLAT, 0 * FLAT),
                Refusal(NoContact, "no pixel has depth in this frame"),
            ),
            "constant depth": (lambda: [e.value for e in _followed(HeightTracker, FLAT, FLAT)], Value([0.0, 0.0])),
            "millimetres": (
                lambda: _followed(HeightTracker, FLAT, 1e3 * FLAT),
                Refusal(InvalidInput, "another unit"),
            ),
            "other resolution": (
                lambda: _followed(HeightTracker, FLAT, FLAT[::2]),
                Refusal(InvalidInput, "reference is of images"),
            ),
        },
        prefix="tracker, ",
    ),
    *group(
        "a false alarm stops the hand in the air, and a miss presses on",
        {
            "constant depth": (lambda: any(_followed(ContactDetector, *[FLAT] * 20)), Value(False)),
            "all invalid": (
                lambda: _followed(ContactDetector, *[FLAT] * 12, 0 * FLAT),
                Refusal(NoContact, "no pixel has depth in this frame"),
            ),
            "one valid pixel": (
                lambda: _followed(ContactDetector, *[FLAT] * 12, one_pixel()),
                Refusal(NoContact, "too few neighbouring"),
            ),
            "half dropped out": (lambda: _followed(ContactDetector, *still(12), half_gone())[-1], Value(True)),
            "concave": (lambda: _followed(ContactDetector, *still(40), 2 * FLAT - press())[-1], Value(False)),
        },
        prefix="detector, ",
    ),
)
