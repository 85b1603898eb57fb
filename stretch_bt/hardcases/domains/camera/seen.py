"""Surfaces that a camera sees from inside, from beside, folded, hidden, bent, or not at all."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Intrinsics, Pose
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception.deprojection import ray_table
from stretch_bt.simulation.camera.fold_kernel import look_through
from stretch_bt.simulation.camera.renderer import _COLUMNS, _ROWS, DepthRenderer, _continued
from stretch_bt.simulation.camera.skin import Grid, Plane, RoundBump, table_under
from stretch_bt.simulation.camera.view import RIGHT, SR305, CameraView, Offset
from stretch_bt.simulation.camera.view_kernel import look
from stretch_bt.simulation.effects.lens_distortion import LensDistortion
from stretch_bt.simulation.membrane.surface import Surface

__all__ = ["CASES", "CROP"]

Depth = npt.NDArray[np.float32]

DISTANCE = 0.2
CROP = SR305.cropped(74, 407, 214, 427)  # the part of the sensor that the membrane fills
BENT = LensDistortion(LensDistortion.Parameters()).lens(SR305)
OFF = Offset(0.003, -0.002, 0.005, 0.05, -0.08)
VIEWS: dict[str, tuple[Intrinsics, Offset]] = {
    "right": (SR305, RIGHT),
    "off": (SR305, OFF),
    "bent": (BENT, RIGHT),
    "bent and off": (BENT, OFF),
}
BELOW = Plane((0.0, 0.0, 1.0), -0.03)


def _bump(x: Any, y: Any) -> Any:
    """Return a smooth height, m, with slopes up to 0.6."""
    return 0.010 * np.exp(-((x - 0.004) ** 2 + (y + 0.003) ** 2) / (2 * 0.011**2))


def _grid(height: Any, pitch: float = 0.7e-3, width: float = 0.09, length: float = 0.12, waist: float = 0.0) -> Grid:
    """Return a sheet over an even grid, narrower at its middle by a share `waist`."""
    u = np.linspace(-width / 2, width / 2, round(width / pitch) + 1)
    v = np.linspace(-length / 2, length / 2, round(length / pitch) + 1)
    x, y = np.meshgrid(u, v)
    x = x * (1 - waist * (1 - (y / (length / 2)) ** 2))
    return Grid(np.stack([x, y, height(x, y)], axis=-1))


def _places(depth: Depth, lens: Intrinsics, offset: Offset) -> Any:
    """Return where in the membrane frame each pixel is, m."""
    view = CameraView(lens, DISTANCE, offset)
    return depth[..., None].astype(float) * ray_table(lens) @ view.turn + view.place


def _rendered(skin: Any, lens: Intrinsics = SR305, offset: Offset = RIGHT, table: Plane | None = None) -> Depth:
    return DepthRenderer(lens, DISTANCE, offset).render(skin, table)


def _on_grid(name: str) -> list[float]:
    """Return how far pixels are off a bump, m, the spans of the seen part less the sheet's, m, and the number of pixels."""
    lens, offset = VIEWS[name]
    depth = _rendered(_grid(_bump), lens, offset)
    x, y, z = np.moveaxis(_places(depth, lens, offset)[depth > 0], -1, 0)
    return [float(np.abs(z - _bump(x, y)).max()), float(np.ptp(x)) - 0.09, float(np.ptp(y)) - 0.12, len(x)]


def _on_profile(name: str) -> list[float]:
    """Return how far pixels are off a profile, m, and by how much they are beside the sheet, m."""
    lens, offset = VIEWS[name]
    flat = Surface(0.008, 0.006, 0.0025, 0.045, 0.015)
    surface = Surface(float(flat.depth - flat.height(0.045 * (1 - 1e-12))), 0.006, 0.0025, 0.045, 0.015)
    depth = _rendered(RoundBump(surface, (0.002, -0.004), 0.09, 0.12), lens, offset)
    x, y, z = np.moveaxis(_places(depth, lens, offset)[depth > 0], -1, 0)
    off = np.abs(z - surface.height(np.hypot(x - 0.002, y + 0.004))).max()
    return [float(off), float(np.abs(x).max()) - 0.045, float(np.abs(y).max()) - 0.06, len(x)]


def _error_at(pitch: float) -> float:
    """Return how far pixels are off a bump on a grid, over the fourth power of its pitch in mm, m."""
    depth = _rendered(_grid(_bump, pitch))
    x, y, z = np.moveaxis(_places(depth, SR305, RIGHT)[depth > 0], -1, 0)
    return float(np.abs(z - _bump(x, y)).max() / (pitch / 1e-3) ** 4)


def _beside() -> bool:
    """Whether the table shows beside a sheet with a waist, the fingers hide its ends, and the sheet hides the table."""
    skin = _grid(_bump, waist=0.1)
    bare, depth = _rendered(skin), _rendered(skin, table=BELOW)
    rows = np.flatnonzero(bare.any(axis=1))
    between = slice(rows[0], rows[-1] + 1)
    beside = depth[between][bare[between] == 0]
    ends = depth[: rows[0]].any() or depth[rows[-1] + 1 :].any()
    waist = abs(np.ptp(np.flatnonzero(bare[240])) - 0.081 / DISTANCE * SR305.fx) <= 2
    same = np.array_equal(depth[bare > 0], bare[bare > 0])
    return bool(same and np.allclose(beside, 0.23, atol=1e-7) and not ends and waist)


def _used_again() -> bool:
    """Whether a renderer that was used shows what a new one does."""
    wide, narrow, used = _grid(_bump), _grid(_bump, width=0.06), DepthRenderer(SR305, DISTANCE)
    views = ((wide, -0.03), (wide, -0.05), (wide, None), (narrow, -0.05), (wide, -0.03))
    for skin, below in views:
        table = None if below is None else Plane((0.0, 0.0, 1.0), below)
        if not np.array_equal(used.render(skin, table), _rendered(skin, table=table)):
            return False
    return True


def _floor(rotation: tuple[float, float, float]) -> list[float]:
    """Return how far the table under a tilted hand is off the world's floor, m, and over how many pixels it is seen."""
    hand = Pose((0.3, -0.1, 0.05), rotation)
    depth, bare = _rendered(_grid(_bump), table=table_under(hand)), _rendered(_grid(_bump))
    seen = _places(depth, SR305, RIGHT)[(depth > 0) & (bare == 0)]
    world = (seen * [1.0, -1.0, 1.0]) @ hand.matrix().T + hand.position
    return [float(np.abs(world[:, 2]).max()), len(seen)]


def _both_ways() -> tuple[int, float]:
    """Return how many pixels only one way to see a surface shows, and by how much both differ, m."""
    skin = _grid(_bump, waist=0.1)
    renderer = DepthRenderer(CROP, DISTANCE)
    first = renderer.render(skin)
    second = np.zeros_like(first)
    column, row, away = renderer.view.project(_continued(skin.points))
    look_through(column, row, away, _ROWS, _COLUMNS, second)
    both = (first > 0) & (second > 0)
    return int(np.count_nonzero((first > 0) != (second > 0))), float(np.abs(first - second)[both].max())


def _at_once(name: str, off: Offset = RIGHT) -> list[float]:
    """Return whether a surface is seen in one pass, how many pixels only that shows or hides, and by how much both ways differ, m."""
    view, image, second = CameraView(CROP, DISTANCE, off), *np.zeros((2, CROP.height, CROP.width), np.float32)
    column, row, away = view.project(_continued(ENDING[name].points))
    seen = look(column, row, away, np.empty((5, len(column), CROP.width)), image)
    look_through(column, row, away, _ROWS, _COLUMNS, second)
    both = (image > 0) & (second > 0)
    return [
        seen,
        int(np.count_nonzero((image > 0) != (second > 0))),
        float(np.abs(image - second)[both].max(initial=0.0)),
    ]


def _folded() -> list[float]:
    """Return how far the nearer leaf of a sheet that turns back under itself is off, m, and the width seen, m."""
    s = np.linspace(0, 1, 161)
    x = np.interp(s, [0, 0.55, 0.65, 1], [-0.03, 0.02, 0.02, -0.01])
    z = np.interp(s, [0, 0.55, 0.65, 1], [0.01, 0.01, 0.0, 0.0])
    y = np.linspace(-0.03, 0.03, 61)
    depth = _rendered(Grid(np.stack(np.broadcast_arrays(x, y[:, None], z), axis=-1)))
    seen = _places(depth, SR305, RIGHT)[depth > 0]
    return [float(np.abs(seen[seen[:, 0] < 0.0185][:, 2] - 0.01).max()), float(np.ptp(seen[:, 0])) - 0.05]


def _hidden() -> list[float]:
    """Return the height of the edge of a steep ridge far to the side, and how far off its shadow's end is, m; -1 out of order."""
    depth = _rendered(_grid(lambda x, y: 0.03 * np.exp(-(((x - 0.035) / 0.004) ** 4)), 0.5e-3, width=0.12))
    line = _places(depth, SR305, RIGHT)[240]
    line = line[depth[240] > 0]
    in_order = np.all(np.diff(line[:, 0] / (DISTANCE - line[:, 2])) > 0)
    jump = np.argmax(np.diff(line[:, 0]))
    shadow = line[jump, 0] * DISTANCE / (DISTANCE - line[jump, 2])
    return [float(line[jump, 2]) if in_order else -1.0, float(line[jump + 1, 0] - shadow)]


def _seen_by_its_ray(name: str) -> float:
    """Return by how many pixels, or parts of 0.19 m, a point is seen elsewhere than by the pixel whose ray meets it."""
    lens, offset = VIEWS[name]
    lens = Intrinsics(lens.fx, lens.fy, lens.cx, lens.cy, 640, 480, lens.distortion)
    v, u = np.mgrid[60:420:40, 120:520:40]
    seen = _places(np.full((480, 640), 0.19, np.float32), lens, offset)[v, u]
    found = CameraView(lens, DISTANCE, offset).project(seen)
    return max(float(np.abs(a - b).max()) for a, b in zip(found, (u, v, 0.19), strict=True))


def _blind(found: Depth) -> bool:
    return found.dtype == np.float32 and not found.any()


def _beyond(offset: float) -> list[float]:
    """Return the smallest depth, whether all are finite, and how far off the middle is, m, over a table that is not seen."""
    depth = _rendered(_grid(_bump), table=Plane((0.0, 0.0, 1.0), offset))
    return [float(depth.min()) >= 0, bool(np.isfinite(depth).all()), float(depth[240, 320]) - 0.2 + float(_bump(0, 0))]


#: sheets that end within the view, or of which rows and columns do
ENDING = {
    "narrow at its middle": _grid(_bump, waist=0.2),
    "wide at its middle": _grid(_bump, width=0.06, waist=-0.4),
    "narrow": _grid(_bump, width=0.03),
    "short": _grid(_bump, length=0.03),
    "wider than the view": _grid(_bump, 1.5e-3, width=0.2),
    "longer than the view": _grid(_bump, 1.5e-3, length=0.4),
}
BLIND: dict[str, tuple[Any, Intrinsics]] = {
    "inside a grid's bulge": (_grid(lambda x, y: 20 * _bump(x, y)), SR305),
    "inside a profile's bulge": (RoundBump(Surface(0.195, 0.01, 0.0, 0.045, math.inf), (0.0, 0.0), 0.09, 0.1), SR305),
    "an empty crop": (_grid(_bump), SR305.cropped(100, 100, 50, 90)),
    "a crop beside the sheet": (_grid(_bump), SR305.cropped(0, 40, 0, 40)),
}
ON_GRID = Check(
    "within 0.3 um of it, and as wide and long as it is",
    lambda f: f[0] < 0.3e-6 and abs(f[1]) < 1e-3 and abs(f[2]) < 1e-3 and f[3] > 50_000,
)
ON_PROFILE = Check(
    "within 0.1 um of it, and nothing beside it",
    lambda f: f[0] < 1e-7 and f[1] <= 1e-9 and f[2] <= 1e-9 and f[3] > 50_000,
)

CASES: tuple[Hard, ...] = (
    *group(
        "a camera that stands and looks askew, through a lens that bends",
        {f"a grid, {name}": (partial(_on_grid, name), ON_GRID) for name in VIEWS},
        {f"a profile, {name}": (partial(_on_profile, name), ON_PROFILE) for name in VIEWS},
        {f"a point by its ray, {name}": (partial(_seen_by_its_ray, name), Value(0.0, abs=2e-5)) for name in VIEWS},
        {
            f"a grid of {1e3 * pitch:g} mm": (
                partial(_error_at, pitch),
                Check("off by the fourth power of the pitch", lambda error: error < 0.6e-6),
            )
            for pitch in (2e-3, 1e-3, 0.5e-3)
        },
    ),
    *group(
        "a surface that folds, hides itself, ends within the view, or was another one before",
        {
            "the table beside a waist": (_beside, Value(True)),
            "a renderer that was used": (_used_again, Value(True)),
            "both ways to see": (
                _both_ways,
                Check("the same but for 5 pixels and 0.5 um", lambda f: f[0] <= 5 and f[1] < 5e-7),
            ),
            "folded under itself": (
                _folded,
                Check("the nearer leaf, 50 mm wide", lambda f: f[0] < 1e-5 and abs(f[1]) < 1e-3),
            ),
            "hidden behind a ridge": (
                _hidden,
                Check(
                    "from the edge of the ridge to the end of its shadow", lambda f: f[0] > 0.015 and abs(f[1]) < 1e-3
                ),
            ),
        },
        {
            f"in one pass, {name}, {'askew' if off is OFF else 'straight'}": (
                partial(_at_once, name, off),
                Check("seen, the same but for 30 pixels and 1 um", lambda f: f[0] and f[1] <= 30 and f[2] < 1e-6),
            )
            for name in ENDING
            for off in (RIGHT, OFF)
        },
        {
            f"the floor under a hand turned by {rotation}": (
                partial(_floor, rotation),
                Check("within 0.1 um of it", lambda f: f[0] < 1e-7 and f[1] > 10_000),
            )
            for rotation in ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, -0.15, 0.3))
        },
    ),
    *group(
        "a camera within the sheet or without pixels sees nothing, and must say so",
        {
            name: (partial(_rendered, skin, lens, RIGHT, BELOW), Check("no pixel has depth", _blind))
            for name, (skin, lens) in BLIND.items()
        },
        {
            f"a table at {offset:g} m": (partial(_beyond, offset), Value([1, 1, 0.0], abs=2e-4))
            for offset in (0.25, -0.2 + 1e-12, -1e4)
        },
    ),
    *group(
        "inputs that are no surface or no camera",
        {
            "a grid of two rows": (lambda: Grid(np.zeros((2, 9, 3))), Refusal(InvalidInput, "at least 3")),
            "a grid of heights": (lambda: Grid(np.zeros((9, 9))), Refusal(InvalidInput, "points")),
            "a grid of no numbers": (lambda: Grid(np.full((9, 9, 3), np.nan)), Refusal(InvalidInput, "finite")),
            "a camera within the membrane": (
                lambda: CameraView(SR305, 0.2, Offset(z=-0.2)),
                Refusal(InvalidInput, "in front"),
            ),
        },
    ),
)
