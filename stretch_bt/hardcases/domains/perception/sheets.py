"""Sheets hung over known heights, as two looks of a press show them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Pose
from stretch_bt.perception.clouds.expected import drape
from stretch_bt.perception.clouds.relief import Relief, add_view
from stretch_bt.perception.clouds.seen import view_of

__all__ = ["MM", "box", "dome", "mapped", "pressed", "surface"]

MM = 1e-3
_STEP = 1.25 * MM
_U = (np.arange(72) + 0.5) * _STEP - 45 * MM
_V = (np.arange(80) + 0.5) * _STEP - 50 * MM

Ground = Callable[[Any, Any], npt.NDArray[Any]]


def box(
    x: Any,
    y: Any,
    half: tuple[float, float] = (20 * MM, 20 * MM),
    top: float = 30 * MM,
    at: tuple[float, float] = (0, 0),
) -> npt.NDArray[Any]:
    """Return the height, m, of a box at places."""
    return np.where((np.abs(x - at[0]) < half[0]) & (np.abs(y - at[1]) < half[1]), top, 0.0)


def dome(
    x: Any,
    y: Any,
    radii: tuple[float, float] = (25 * MM, 20 * MM),
    top: float = 20 * MM,
    at: tuple[float, float] = (0, 0),
) -> npt.NDArray[Any]:
    """Return the height, m, of half an ellipsoid at places."""
    part = np.maximum(1 - ((x - at[0]) / radii[0]) ** 2 - ((y - at[1]) / radii[1]) ** 2, 0.0)
    return np.asarray(top * np.sqrt(part))


def surface(ground: Ground, x: float, y: float, yaw: float, height: float) -> npt.NDArray[Any]:
    """Return a sheet over a ground, in the membrane frame, whose y runs against the hand's."""
    c, s = np.cos(yaw), np.sin(yaw)
    u, v = _U[:, None], _V[None, :]
    sheet = drape(ground(x + c * u - s * v, y + s * u + c * v)[None], np.array([height]))[0]
    sheet, u, v = _finer(sheet), _finer(u + 0 * v), _finer(v + 0 * u)
    shape = sheet.shape
    return np.stack([np.broadcast_to(u, shape), np.broadcast_to(-v, shape), sheet - height], axis=2)


def _finer(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return values halfway between the rows and the columns as well."""
    for axis in (0, 1):
        first, last = (
            np.take(values, range(*span), axis) for span in ((0, values.shape[axis] - 1), (1, values.shape[axis]))
        )
        both = np.stack([first, (first + last) / 2], axis=axis + 1)
        values = both.reshape([-1 if k == axis else n for k, n in enumerate(first.shape)])
    return values


def pressed(
    ground: Ground,
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
    height: float = 15 * MM,
    noise: float = 0.0,
    seed: int = 0,
) -> Any:
    """Return the view of a press over a ground: a look at a height, and one 2 mm above it."""
    rng = np.random.default_rng(seed)
    poses = [Pose((x, y, h), (0.0, 0.0, yaw)) for h in (height, height + 2 * MM)]
    deep, shallow = (
        surface(ground, x, y, yaw, p.height) + np.array([0, 0, noise]) * rng.normal(0, 1, (142, 158, 1)) for p in poses
    )
    return view_of(deep, shallow, deep_pose=poses[0], shallow_pose=poses[1], half_length=50 * MM)


def mapped(ground: Ground, *poses: tuple[float, float, float], **options: Any) -> Relief:
    """Return the map of presses at (x, y, yaw)."""
    relief = None
    for pose in poses:
        relief = add_view(pressed(ground, *pose, **options), relief)
    assert relief is not None
    return relief
