"""Lengths, curvatures, points and paths that are none, given to what looks at a membrane as a whole."""

from __future__ import annotations

from functools import cache, partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardcases.domains.perception.pressed_frames import DISTANCE, FLAT, LENS, cloud, frame, labels, press
from stretch_bt.hardcases.expect import Refusal
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception import (
    FreeView,
    MountedMembrane,
    cloud_of,
    load_depth_png,
    load_depth_stack,
    membrane_height,
    mounted_membrane,
    track_height,
    view_rays,
)
from stretch_bt.units import Estimate

NAN, INF = float("nan"), float("inf")


@cache
def _view() -> FreeView:
    view = FreeView()
    view.add(frame(FLAT))
    view.settle()
    return view


def _pattern(*given: Any) -> Any:
    return _view().pattern(*given)


def _mounted(**changes: Any) -> Any:
    made: dict[str, Any] = {"gauge": 0.1, "width": 0.09, "thickness": 0.002, "prestretch": 0.01, "stretch": 0.02}
    membrane = mounted_membrane(**{**made, **changes}, hang=Estimate(1e-4, 5e-5))
    return membrane_height(*cloud(press()), membrane, Estimate(50.0, 1.0), 0.008)


def _tracked(curvature: Estimate) -> Any:
    return track_height(*cloud(press()), labels(press()), curvature=curvature)


NO_LENGTH = Refusal(InvalidInput, "gauge is a finite number, in m")
SHORT = Refusal(InvalidInput, "gauge.*above 0 m")
PATTERNS: dict[str, tuple[tuple[Any, ...], Refusal]] = {
    "a gauge NaN": ((NAN,), NO_LENGTH),
    "an infinite gauge": ((INF,), NO_LENGTH),
    "a gauge in words": (("0.1",), NO_LENGTH),
    "no gauge": ((None,), NO_LENGTH),
    "a gauge of 0": ((0.0,), SHORT),
    "a gauge below 0": ((-0.1,), SHORT),
    "a gauge in millimetres": ((100.0,), SHORT),
    "a sag without a deviation": ((0.1, 3e-4), Refusal(InvalidInput, "hang is an Estimate")),
    "a sag NaN": ((0.1, Estimate(NAN, 1e-4)), Refusal(InvalidInput, "hang must be finite")),
    "a width of 0": ((0.1, Estimate(3e-4, 3e-4), 0.0), Refusal(InvalidInput, "width is a length above 0 m")),
    "a width NaN": ((0.1, Estimate(3e-4, 3e-4), NAN), Refusal(InvalidInput, "width is a length above 0 m")),
}
MOUNTS: dict[str, dict[str, float]] = {
    "shorter than nothing by its mount": {"prestretch": -0.2},
    "shorter than nothing by its stretch": {"stretch": -0.13},
    "of no length at stretch 0": {"prestretch": -0.1, "stretch": 0.1},
}
CURVATURES = {"1e300": Estimate(1e300, 1.0), "-1e300": Estimate(-1e300, 1.0), "known to 1e300": Estimate(50.0, 1e300)}
PATHS: dict[str, Any] = {
    "an image": partial(load_depth_png, unit=1e-4, intrinsics=LENS),
    "a stack": partial(load_depth_stack, unit=1e-4, intrinsics=LENS, key="z", times=[0.0]),
    "a cloud": lambda path: cloud_of(np.zeros((0, 3)), 1e-3).save(path),
}

CASES: tuple[Hard, ...] = (
    *group(
        "a length or a sag that is no number, or none of a membrane, makes a static error of NaN",
        {name: (partial(_pattern, *given), refusal) for name, (given, refusal) in PATTERNS.items()},
        prefix="static error, ",
    ),
    *group(
        "clamps that stand closer than nothing, and a curvature whose square is past all numbers",
        {
            f"a membrane {name}": (partial(_mounted, **changes), Refusal(InvalidInput, "clamps stand.*above 0 m"))
            for name, changes in MOUNTS.items()
        },
        {
            "a membrane made without clamps": (
                partial(MountedMembrane, 0.1, 0.09, 0.002, -0.2, Estimate(1e-4, 5e-5)),
                Refusal(InvalidInput, "clamps stand.*above 0 m"),
            )
        },
        {"a membrane that is pulled": (_mounted, Refusal(IllConditioned, "middle of the membrane"))},
        {
            f"a curvature {name}": (partial(_tracked, given), Refusal(InvalidInput, "curvature.*no surface is bent"))
            for name, given in CURVATURES.items()
        },
        prefix="whole membrane, ",
    ),
    *group(
        "no ray goes from the camera through itself",
        {
            "a point at the camera": (partial(view_rays, np.zeros((1, 3))), Refusal(InvalidInput, "at the camera")),
            "a point at a camera elsewhere": (
                partial(view_rays, np.full((2, 3), DISTANCE), (DISTANCE,) * 3),
                Refusal(InvalidInput, "at the camera"),
            ),
        },
        prefix="rays, ",
    ),
    *group(
        "a path that no system opens",
        {
            f"{name}, {kind}": (partial(call, path), Refusal(InvalidInput, "path is the path of a file"))
            for name, call in PATHS.items()
            for kind, path in (("None", None), ("with a null", "a\0b.ply"))
        },
        prefix="path, ",
    ),
)
