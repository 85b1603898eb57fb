"""Settings without sense, and contacts that show no height, lift, line, ratio or width."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.perception import (
    Contact,
    ContactDetector,
    HeightTracker,
    contact_width,
    lift_off,
    outline_at,
    tension_ratio,
    track_height,
)
from stretch_bt.perception.reference import Reference
from stretch_bt.perception.types import CONTACT, SurfaceNoise
from stretch_bt.units import Estimate

PITCH, PIXEL = 0.4e-3, 1e-3
NAN, INF = float("nan"), float("inf")


def _at_heights(change: Any) -> Any:
    """Return the height of 8 x 8 points, of which `change` says which touch."""
    points, labels = np.zeros((8, 8, 3)), np.zeros((8, 8), np.uint8)
    change(points, labels)
    return track_height(points, np.ones((8, 8), bool), labels)


def _four(points: Any, labels: Any) -> None:
    labels[0, :4] = CONTACT


def _one_height(points: Any, labels: Any) -> None:
    points[..., 0], labels[:] = np.arange(64).reshape(8, 8), CONTACT


def _line(points: Any, labels: Any) -> None:
    _one_height(points, labels)
    points[0, 0, 2] = 1e-3


def _reached(by: float, reach: bool = True) -> Any:
    y, x = np.mgrid[:40, :40] * 4e-4
    points, labels = np.dstack([x, y, by + 1e-4 * np.sin(9e4 * x * y)]), np.full(x.shape, CONTACT, dtype=np.uint8)
    limit = HandGeometry().reach(0.02) if reach else None
    return track_height(points, np.ones(x.shape, bool), labels, reach=limit)


def _lifted(
    thickness: float = 2e-3, strain: float = 0.12, gauge: float = 0.1, height: float = 0.01, shape: Any = (4, 4)
) -> Any:
    return lift_off(np.zeros((4, 4, 3)), np.zeros(shape, np.uint8), height, thickness, Estimate(strain, 0.0), gauge)


def _over(top: float) -> Any:
    """Return a membrane that falls by 0.3 m/m from the border of a flat top 24 mm wide."""
    v, u = np.mgrid[:160, :160]
    x, y = (u - 80) * PITCH, (v - 80) * PITCH
    past = np.maximum(np.hypot(x, y) - 0.012, 0.0)
    return np.stack([x, y, np.maximum(top - 0.3 * past, 0.0)], axis=2)


def _skirt(rng: np.random.Generator) -> Any:
    """Return second derivatives of a membrane that is not bent beyond its noise."""
    common, own, other = rng.standard_normal((3, 900))
    return (common + np.sqrt(2) * own) / np.sqrt(3), (common + np.sqrt(2) * other) / np.sqrt(3)


def _no_membrane(rng: np.random.Generator) -> Any:
    along = np.linspace(-9, 9, 500)
    return rng.normal(size=500) * 1e-3 + along, along


Y, X = np.meshgrid(PITCH * np.arange(-100, 101), PITCH * np.arange(-80, 81), indexing="ij")
PLANE = np.stack([X, Y, np.full(X.shape, 5e-3)], axis=-1)


def _wide(lonely: bool, count: int = 1) -> Any:
    points, labels = PLANE.copy(), np.ones(X.shape, np.uint8)
    if lonely:
        points[::2] = points[:, ::2] = np.nan
    labels[101, 81 : 81 + count] = 2
    return contact_width(points, labels)


def _compared(depth: Any) -> Any:
    reference = Reference(2)
    known = np.full((20, 20), 0.2)
    known[:, :10] = 0.0
    reference.learn(known)
    return reference.rise(depth)


def _lost(make: Any) -> Any:
    follower = make(reference=1)
    follower.update(np.full((30, 40), 0.2))
    return follower.update(np.zeros((30, 40)))


CAP = np.maximum(6e-3 - (np.arange(-40, 41)[:, None] ** 2 + np.arange(-30, 31)[None, :] ** 2) * 1e-6 / 40e-3, 0.0)
BY_HAND: dict[str, tuple[Any, float, dict[str, Any], Refusal]] = {
    "flat": (0 * CAP, PIXEL, {}, Refusal(NoContact, "say with 'labels' which pixels touch")),
    "a line": (CAP[0], PIXEL, {}, Refusal(InvalidInput, r"heights are an array \(h, w\) of numbers, m")),
    "truths": (CAP > 0, PIXEL, {}, Refusal(InvalidInput, "got bool")),
    "nothing seen": (CAP * np.nan, PIXEL, {}, Refusal(NoContact, "nothing is seen")),
    "millimetres": (CAP * 1e3, PIXEL, {}, Refusal(InvalidInput, "give heights and pixel in m")),
    "millimetres, with labels": (
        CAP * 1e3,
        PIXEL * 1e3,
        {"noise": 0.1, "labels": CAP > 0},
        Refusal(InvalidInput, "1 m from pixel to pixel"),
    ),
    "a pixel of no size": (CAP, 0.0, {}, Refusal(InvalidInput, "write 0.0005 for 0.5 mm")),
    "noise below 0": (CAP, PIXEL, {"noise": -1.0}, Refusal(InvalidInput, "pixel and noise are lengths above 0 m")),
    "labels of another shape": (
        CAP,
        PIXEL,
        {"labels": np.zeros((3, 3))},
        Refusal(InvalidInput, r"have that shape, got \(3, 3\)"),
    ),
    "unknown classes": (
        CAP,
        PIXEL,
        {"labels": np.full(CAP.shape, 7)},
        Refusal(InvalidInput, "labels are 0 undeformed"),
    ),
}


def _by_hand(heights: Any, pixel: float, options: dict[str, Any]) -> Contact:
    return Contact.from_heights(heights, pixel, **{"noise": 1e-4, **options})


LIFTS: dict[str, dict[str, Any]] = {
    "no thickness": {"thickness": 0.0},
    "no strain": {"strain": 0.0},
    "a thickness below 0": {"thickness": -1e-3},
    "an infinite strain": {"strain": INF},
    "a thickness NaN": {"thickness": NAN},
    "no gauge": {"gauge": 0.0},
}

CASES: tuple[Hard, ...] = (
    *group(
        "a contact of no point, of four, of one height, on a line, or past the membrane's reach",
        {
            "nothing touches": (lambda: _at_heights(lambda p, v: None), Refusal(NoContact)),
            "four points touch": (lambda: _at_heights(_four), Refusal(IllConditioned, "twelve")),
            "all at one height": (lambda: _at_heights(_one_height), Refusal(IllConditioned, "one height")),
            "on a line": (lambda: _at_heights(_line), Refusal(IllConditioned, "line")),
            "higher than it reaches": (partial(_reached, 1.8), Refusal(IllConditioned, "cannot")),
            "as high as it reaches": (partial(_reached, 0.01), Value(0.01, abs=1e-4, of=lambda top: top.value)),
            "a reach that is not known": (
                partial(_reached, 1.8, False),
                Value(1.8, abs=1e-3, of=lambda top: top.value),
            ),
        },
        prefix="height, ",
    ),
    *group(
        "a membrane without thickness, strain or gauge resists nothing, or everything",
        {
            name: (partial(_lifted, **options), Refusal(InvalidInput, "must be (above 0|finite)"))
            for name, options in LIFTS.items()
        },
        {
            f"a height of {h:g}": (partial(_lifted, height=h), Refusal(InvalidInput, "must be finite"))
            for h in (NAN, INF)
        },
        {
            f"labels {shape}": (partial(_lifted, shape=shape), Refusal(InvalidInput, "shape"))
            for shape in ((3, 4), (16,), (4, 4, 1))
        },
        prefix="lift, ",
    ),
    *group(
        "there is no line below a top that is too low or not seen, and no ratio in a surface that is not bent",
        {
            "a line under half a millimetre": (partial(outline_at, _over(0.0005), 0.001), Refusal(NoContact)),
            "a line under too low a top": (partial(outline_at, _over(0.002), 0.0015), Refusal(NoContact)),
            "a line of nothing seen": (partial(outline_at, np.full((20, 20, 3), NAN), 0.001), Refusal(NoContact)),
            "a line at the top": (partial(outline_at, _over(0.012), 0.0), Refusal(InvalidInput)),
            "noise that is no number": (partial(SurfaceNoise, NAN, 1.0), Refusal(InvalidInput, "finite deviation")),
            "noise of less than a pixel": (partial(SurfaceNoise, 1e-4, 0.5), Refusal(InvalidInput, "1 or more pixels")),
            "a line of heights": (partial(outline_at, np.zeros((20, 20)), 0.001), Refusal(InvalidInput)),
            "a ratio of ten places": (
                partial(tension_ratio, np.zeros(10), np.zeros(10)),
                Refusal(IllConditioned, "thirty places"),
            ),
            "a ratio of noise": (
                lambda: tension_ratio(*_skirt(np.random.default_rng(0))),
                Refusal(IllConditioned, "not bent beyond"),
            ),
            "a ratio of no membrane": (
                lambda: tension_ratio(*_no_membrane(np.random.default_rng(0))),
                Refusal(IllConditioned, "no membrane"),
            ),
        },
    ),
    *group(
        "a contact of one pixel, or of pixels without neighbours",
        {
            "of one pixel": (
                partial(_wide, False),
                Check(
                    "a pixel wide, known to a third of it",
                    lambda f: np.allclose([f.i, f.j], PITCH) and min(f.i_sd, f.j_sd) > PITCH / 3,
                ),
            ),
            "without neighbours": (partial(_wide, True), Refusal(IllConditioned, "neighbours")),
            "of nothing": (partial(_wide, False, 0), Refusal(NoContact, "no pixel is in contact")),
        },
        prefix="width, ",
    ),
    *group(
        "a tracker or a detector without frames, width or probability, and frames that do not fit",
        {
            "no frame to learn": (
                lambda: HeightTracker(reference=0),
                Refusal(InvalidInput, "reference is a whole number from 1 on"),
            ),
            "a kernel of no width": (lambda: HeightTracker(kernel=0.0), Refusal(InvalidInput, "kernel")),
            "a kernel below 0": (lambda: ContactDetector(kernel=-1.0), Refusal(InvalidInput, "kernel")),
            "no false alarm ever": (lambda: ContactDetector(false_alarms=0.0), Refusal(InvalidInput, "probability")),
            "a memory of two frames": (lambda: ContactDetector(memory=2), Refusal(InvalidInput, "memory")),
            "another resolution": (lambda: _compared(np.full((20, 21), 0.2)), Refusal(InvalidInput, "shape")),
            "depth elsewhere": (
                lambda: _compared(np.where(np.arange(20) < 10, 0.2, 0.0) * np.ones((20, 1))),
                Refusal(NoContact, "no pixel has depth"),
            ),
            "a tracker that sees nothing": (lambda: _lost(HeightTracker), Refusal(NoContact)),
            "a detector that sees nothing": (lambda: _lost(ContactDetector), Refusal(NoContact)),
        },
        prefix="followed, ",
    ),
    *group(
        "heights by hand that are flat, no numbers, in another unit or of another shape",
        {
            name: (partial(_by_hand, heights, pixel, options), refusal)
            for name, (heights, pixel, options, refusal) in BY_HAND.items()
        },
        {"a cap": (partial(_by_hand, CAP, PIXEL, {}), Range(100, of=lambda contact: len(contact.points)))},
        prefix="by hand, ",
    ),
)
