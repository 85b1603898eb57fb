"""Depth images as cameras send them: deprojection, mask, average and noise."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import Intrinsics
from stretch_bt.hardcases.domains.perception.pressed_frames import (
    FLAT,
    LENS,
    SATURATED,
    H,
    W,
    frame,
    one_pixel,
    with_pixels,
)
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.perception import average_frames, deproject, frame_noise, mask_membrane, pixel_noise

NAN, INF = float("nan"), float("inf")


def _unplaced() -> Any:
    return dataclasses.replace(frame(FLAT), plane_distance=None)


def _saturated() -> Any:
    return dataclasses.replace(frame(FLAT), raw=np.full((H, W), 65535, np.uint16))


def _masked(given: Any, width: float) -> Any:
    return mask_membrane(given, gauge=0.1, width=width, stretch=0.0)


CASES = (
    *group(
        "every image passes here, with any size, unit and pixels without depth that cameras send",
        {
            "empty image": (
                lambda: deproject(np.zeros((0, 0)), Intrinsics(1, 1, 0, 0, 0, 0))[0].shape,
                Value((0, 0, 3)),
            ),
            "all invalid": (lambda: deproject(0 * FLAT, LENS)[1].any(), Value(False)),
            "NaN and inf": (
                lambda: deproject(with_pixels(FLAT, {(0, 0): NAN, (0, 1): INF, (0, 2): -INF}), LENS)[1].sum(),
                Value(H * W - 3),
            ),
            "float32 stays": (lambda: deproject(FLAT, LENS)[0].dtype.name, Value("float32")),
            "millimetres": (
                lambda: deproject(1e3 * FLAT, LENS),
                Refusal(InvalidInput, "median of 200 m is another unit"),
            ),
            "kilometres": (lambda: deproject(1e-3 * FLAT, LENS), Refusal(InvalidInput, "another unit")),
            "counts": (
                lambda: deproject(np.ones((H, W), np.uint16), LENS),
                Refusal(InvalidInput, "counts by their unit"),
            ),
            "other resolution": (
                lambda: deproject(FLAT[::2, ::2], LENS),
                Refusal(InvalidInput, "160 rows by 200 columns, the image is"),
            ),
            "saturated": (
                lambda: deproject(np.full((H, W), SATURATED, dtype=np.float32), LENS)[1].all(),
                Value(True),
            ),
        },
        prefix="deproject, ",
    ),
    *group(
        "a mask needs the distance of the membrane, and may leave nothing",
        {
            "no plane": (lambda: _masked(_unplaced(), 0.09), Refusal(InvalidInput, "plane_distance")),
            "millimetres": (
                lambda: mask_membrane(frame(FLAT), gauge=100.0, width=90.0, stretch=0.0),
                Refusal(InvalidInput, "no side of a membrane is above 2 m"),
            ),
            "stretch in millimetres": (
                lambda: mask_membrane(frame(FLAT), gauge=0.1, width=0.09, stretch=30.0),
                Refusal(InvalidInput, "write 0.09 for 90 mm"),
            ),
            "narrower than its margin": (lambda: _masked(frame(FLAT), 1e-3).raw.any(), Value(False)),
        },
        prefix="mask, ",
    ),
    *group(
        "a mean over frames has nothing to divide by where no frame has depth, and may overflow",
        {
            "nothing": (lambda: average_frames([]), Refusal(InvalidInput, "at least one frame")),
            "all invalid": (lambda: average_frames([frame(0 * FLAT)] * 3).raw.any(), Value(False)),
            "two resolutions": (
                lambda: average_frames([frame(FLAT), frame(FLAT[::2])]),
                Refusal(InvalidInput, "unit or intrinsics"),
            ),
            "saturated counts": (lambda: average_frames([_saturated()] * 2).raw.max(), Value(65535)),
        },
        prefix="average, ",
    ),
    *group(
        "noise is measured between neighbours: there may be none, and they may be equal",
        {
            "constant depth": (
                lambda: pixel_noise(FLAT),
                Check("no noise above 10 nm", lambda found: found.sd.max() < 1e-8),
            ),
            "one valid pixel": (lambda: pixel_noise(one_pixel()), Refusal(IllConditioned, "valid throughout")),
            "millimetres": (lambda: pixel_noise(1e3 * FLAT), Refusal(InvalidInput, "another unit")),
        },
        prefix="noise, ",
    ),
    *group(
        "frames that are all alike have no noise to correlate",
        {"constant depth": (lambda: frame_noise([FLAT] * 8).correlation, Value(np.zeros(5)))},
        prefix="noise of frames, ",
    ),
)
