"""Cameras that there are not, images that are none, and frames that cost."""

from __future__ import annotations

import dataclasses
from functools import cache, partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardcases.domains.perception.pressed_frames import LENS as PRESSED
from stretch_bt.hardcases.domains.perception.pressed_frames import cloud, frame, press
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception import (
    average_frames,
    classify,
    curvatures,
    deproject,
    estimate_normals,
    find_contact,
    fit_sphere,
    mask_membrane,
    outline_at,
    segment,
    surface_noise,
)

H, W = 480, 640
LENS = Intrinsics(474.0, 474.0, 319.5, 239.5, W, H)
SMALL = Intrinsics(40.0, 40.0, 15.0, 10.0, 30, 20)
NAN, INF = float("nan"), float("inf")


def _frame(raw: Any, lens: Intrinsics = LENS, **changes: Any) -> DepthFrame:
    return DepthFrame(np.asarray(raw, np.uint16), 0.000125, lens, 0.0, 0, 0.2, **changes)


@cache
def _flat() -> DepthFrame:
    return _frame(np.full((H, W), 1600))


def _four_far() -> Any:
    raw = np.zeros((H, W))
    raw[[0, 0, -1, -1], [0, 1, 0, -1]] = 5600
    return raw


def _salt(share: float, low: int = 0, high: int = 65535) -> Any:
    rng = np.random.default_rng(0)
    return np.where(rng.random((H, W)) < share, rng.integers(low, high, (H, W)), 1600)


def _bumps() -> Any:
    u, v = (np.cos(2 * np.pi * np.arange(n) / 40) for n in (W, H))
    return np.rint(1560 - 40 * v[:, None] * u[None, :])


def _stairs() -> Any:
    return np.broadcast_to(1600 + 20 * (np.arange(W) // 80), (H, W))


def _holes_in_holes() -> Any:
    v, u = np.indices((H, W))
    return np.where(u & v, 1600, 1500)


COSTLY: dict[str, Any] = {
    "stairs": _stairs,
    "holes in holes": _holes_in_holes,
    "four pixels": _four_far,
    "salt": partial(_salt, 0.3),
    "salt near": partial(_salt, 0.5, 1000, 1800),
    "bumps": _bumps,
    "at the lens": lambda: np.full((H, W), 16),
}


def _looked(make: Any, rule: Any) -> str:
    """Return the refusal of a frame, `contact` where it has one."""
    try:
        find_contact(_frame(make()), rule=rule)
    except (NoContact, IllConditioned, InvalidInput) as refused:
        return str(refused)
    return "contact"


def _lens(**changes: Any) -> Intrinsics:
    return dataclasses.replace(LENS, **changes)


def _aside(**changes: Any) -> Any:
    return deproject(_frame(np.full((H, W), 1600), _lens(**changes)))


def _high(rows: int = 2) -> Any:
    """Return points of a press by pixels `rows` times as high as wide, in the membrane frame, and which are valid."""
    points, valid = cloud(press())
    return points[::rows].copy(), valid[::rows].copy()


def _near_top(points: Any, valid: Any) -> Any:
    return points[valid & (np.hypot(points[..., 0], points[..., 1]) < 8e-3)]


def _high_frame(share: float) -> DepthFrame:
    """Return a press seen by a camera whose fy is a share of its fx."""
    return dataclasses.replace(frame(press()), intrinsics=dataclasses.replace(PRESSED, fy=PRESSED.fx * share))


def _distorted() -> float:
    """Return how far rays through a lens that bends them every way are off the inverse Brown-Conrady model, at unit depth."""
    k1, k2, p1, p2, k3 = distortion = (0.1, -0.2, 0.01, -0.02, 0.05)
    rays = deproject(np.ones((H, W)), _lens(distortion=distortion))[0]
    y, x = np.mgrid[:H, :W]
    x, y = (x - LENS.cx) / LENS.fx, (y - LENS.cy) / LENS.fy
    r2 = x**2 + y**2
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    across, down = 2 * p1 * x * y + p2 * (r2 + 2 * x**2), 2 * p2 * x * y + p1 * (r2 + 2 * y**2)
    return float(max(np.abs(rays[..., 0] - x * radial - across).max(), np.abs(rays[..., 1] - y * radial - down).max()))


def _with(**changes: Any) -> DepthFrame:
    return dataclasses.replace(_flat(), **changes)


def _of_kind(kind: str) -> list[Any]:
    """Return whether all is valid, the type of points of a depth image of a kind, and how far they are off, m."""
    depth = np.full((20, 30), 0.25) + np.arange(30) / 1024
    given: Any = depth.tolist() if kind == "list" else depth.astype(kind)
    points, valid = deproject(given, SMALL)
    shape = segment(points.astype("g"), valid).shape
    return [bool(valid.all()), points.dtype.name, float(np.abs(points[..., 2] - depth).max()), shape]


def _is_kind(kind: str) -> Check:
    half, name = kind.endswith("2"), "float32" if kind.endswith(("2", "4")) else "float64"
    within = 1e-3 if half else 1e-7
    return Check(
        f"{name} within {within:g} m",
        lambda f: f[0] and f[1] == name and f[2] <= within and f[3] == (20, 30),
    )


def _averaged(name: str, by: float) -> Any:
    still = _with(stretch=0.02, hand_height=0.1)
    moved: Any = {name: {"stretch": 0.02, "hand_height": 0.1}[name] + by}
    unknown: Any = {name: None}
    return average_frames([still, dataclasses.replace(still, **moved), dataclasses.replace(still, **unknown)]).raw.any()


NO_CAMERA = Refusal(InvalidInput, "intrinsics are finite|focal lengths are above 0")
ASIDE = Refusal(InvalidInput, "aside for each metre ahead")
NOT_SQUARE = Refusal(InvalidInput, "pixels are square within 2%.*resample the depth image")
OF_SQUARE: dict[str, Any] = {
    "labels": lambda: segment(*_high()),
    "normals": lambda: estimate_normals(*_high()),
    "curvatures": lambda: curvatures(*_high()),
    "noise": lambda: surface_noise(_high()[0]),
    "a line": lambda: outline_at(_high()[0], 2e-3),
    "a contact, 50 % off": lambda: find_contact(_high_frame(0.5)),
    "a contact, 3 % off": lambda: find_contact(_high_frame(0.97)),
}
NO_IMAGE: dict[str, Any] = {
    "ragged rows": [[0.2, 0.2], [0.2]],
    "text": "depth",
    "nothing": None,
    "whole numbers": [[1, 2]],
    "complex numbers": np.zeros((2, 2), complex),
}

CASES: tuple[Hard, ...] = (
    *group(
        "frames of stairs, salt and holes must not hang, and end in a contact or a reason",
        {
            f"{name}, {rule}": (
                partial(_looked, make, rule),
                Check("a contact, or a reason", lambda said: said == "contact" or len(said) > 20),
            )
            for name, make in COSTLY.items()
            for rule in ("mean", "either")
        },
        {
            "hundreds of bulges": (
                lambda: classify(*deproject(_frame(_salt(0.3))), towards=-1),
                Refusal(IllConditioned, "separate places look curved"),
            ),
            "steps across the whole frame": (
                lambda: segment(*deproject(_frame(_stairs()))),
                Refusal(IllConditioned, "spread over the whole of the frame"),
            ),
        },
        prefix="frame of ",
    ),
    *group(
        "a lens that no camera has, or that looks aside or at one point with all its pixels",
        {
            "no focal length": (partial(_lens, fx=0.0), NO_CAMERA),
            "a focal length below 0": (partial(_lens, fy=-474.0), NO_CAMERA),
            "a focal length NaN": (partial(_lens, fx=NAN), NO_CAMERA),
            "an infinite centre": (partial(_lens, cx=INF), NO_CAMERA),
            "distortion NaN": (partial(_lens, distortion=(0.0, 0.0, NAN, 0.0, 0.0)), NO_CAMERA),
            "a focal length of nothing": (partial(_aside, fx=1e-3), ASIDE),
            "a centre far away": (partial(_aside, cx=1e12), ASIDE),
            "distortion of millions": (partial(_aside, distortion=(1e6, 0.0, 1e6, 0.0, 1e6)), ASIDE),
            "distortion past all numbers": (partial(_aside, distortion=(0.0, 0.0, 0.0, 0.0, 1e308)), ASIDE),
            "tangential distortion": (_distorted, Value(0.0, abs=1e-12)),
            "rays that are all one": (
                lambda: find_contact(_frame(np.full((H, W), 1600), _lens(fx=1e12))),
                Refusal(InvalidInput, "from pixel to pixel"),
            ),
        },
        prefix="lens, ",
    ),
    *group(
        "pixels that are higher than wide, where one width stands for both sides of a pixel",
        {name: (call, NOT_SQUARE) for name, call in OF_SQUARE.items()},
        {
            "a contact, 1 % off": (lambda: len(find_contact(_high_frame(0.99)).points), Range(100)),
            "points": (lambda: deproject(_high_frame(0.5))[0].shape, Value((160, 200, 3))),
            "a fit over the one by square pixels": (
                lambda: fit_sphere(_near_top(*_high())).radius / fit_sphere(_near_top(*_high(1))).radius,
                Value(1.0, abs=0.05),
            ),
        },
        prefix="pixels not square, ",
    ),
    *group(
        "an input that is no depth image, an image without a unit or a distance, and a hand that does not stand still",
        {
            f"{name}": (partial(deproject, image, SMALL), Refusal(InvalidInput, "depth image"))
            for name, image in NO_IMAGE.items()
        },
        {
            f"depths as {kind}": (partial(_of_kind, kind), _is_kind(kind))
            for kind in ("f2", ">f2", "f4", ">f4", "f8", ">f8", "g", "list")
        },
        {
            f"{name} {value:g}": (partial(_with, **{name: value}), Refusal(InvalidInput, f"{name} of a depth frame"))
            for name in ("unit", "plane_distance")
            for value in (0.0, -0.1, NAN, INF)
        },
        {
            "a mask without end": (
                lambda: mask_membrane(_flat(), gauge=0.1, width=0.09, stretch=INF),
                Refusal(InvalidInput, "finite"),
            ),
        },
        {
            f"{name} off by {1e3 * by:g} mm": (
                partial(_averaged, name, by),
                Value(True) if by < 5e-3 else Refusal(IllConditioned, "wait until the hand stands still"),
            )
            for name in ("stretch", "hand_height")
            for by in (1e-3, 10e-3)
        },
        prefix="image, ",
    ),
)
