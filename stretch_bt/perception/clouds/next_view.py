"""Where to press next: the place and turn of the hand that is expected to show most of what was not felt yet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.clouds.coverage import Hidden, hidden
from stretch_bt.perception.clouds.expected import drape
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.units import Angle, Area, Length

__all__ = ["LookFrom", "next_view"]

Array = npt.NDArray[np.float64]

GRID = 3e-3  # m, of the sheet that stands in for the membrane
NEAR = 0.3e-3  # m from the ground within which it touches
OFFSETS = (-0.028, -0.014, 0.0, 0.014, 0.028)  # m from the middle of the object
MOST = 12  # places over what was not seen that are tried beside those
FINGER = 0.015  # m, of the fingers beyond the clamps
FLANK, MARGIN = np.tan(np.radians(65.0)), 4e-3  # of the object beside what was felt, and m; no finger goes there
LITTLE = (12e-6, 0.015)  # m^2, and share of what was felt: less is not worth a press
SIDE = 2  # nodes along each free side of the sheet: one that lies over the object may slip off it
TAKEN = (8e-3, np.radians(30.0))  # m and rad: as near to a pose that was used, another shows nothing new


@dataclass(frozen=True, slots=True)
class LookFrom:
    """Place, m, world, and turn about the vertical, rad, of a press, and the area, m^2, that it is expected to add."""

    x: Length
    y: Length
    yaw: Angle
    gain: Area


def next_view(
    relief: Relief,
    *,
    depth: float,
    length: float,
    width: float,
    x: tuple[float, float] = (-np.inf, np.inf),
    y: tuple[float, float] = (-np.inf, np.inf),
    unseen: Hidden | None = None,
) -> LookFrom | None:
    """Return the pose whose press is expected to show most unseen surface, or None where none shows more than a little.

    Where a surface may go on unseen it is taken to fall off as steeply as what is looked for. A sheet is hung over it from
    each of many poses, its hand `depth` below the top, and what it touches of the unseen counts: in truth the membrane then
    either feels a surface there or hangs below it, and carves it away. Poses at which the object lies under a free side of the
    sheet come last.

    Parameters
    ----------
    relief : Relief
        What is known so far; a pose that was pressed from is not returned again.
    depth : float, m
        Of the hand below the highest place felt.
    length, width : float, m
        Of the membrane, from clamp to clamp and across.
    x, y : (least, most), m
        Where the hand may go.

    Raises
    ------
    InvalidInput
        A length is not positive.
    NoContact
        Nothing was felt yet.
    """
    if not min(depth, length, width) > 0:
        raise InvalidInput(f"depth, length and width must be above 0 m, got {depth}, {length} and {width}")
    top, unseen = relief.top, hidden(relief) if unseen is None else unseen
    poses = _poses(relief, unseen, x, y)
    if not len(poses) or not unseen.cells.any():
        return None
    level, reach = max(top - depth, 0.0), round(FINGER / GRID)
    x_at, y_at = _grid(poses, length, width)
    under = relief.at(_in_the_way(relief, level), x_at, y_at, False)
    clear = ~(under[:, :, : reach + 1].any(axis=(1, 2)) | under[:, :, -reach - 1 :].any(axis=(1, 2)))
    slips = np.concatenate([under[clear, :SIDE], under[clear, -SIDE:]], axis=1).any(axis=(1, 2))
    poses, x_at, y_at = poses[clear], x_at[clear, :, reach:-reach], y_at[clear, :, reach:-reach]
    if not len(poses):
        return None
    ground = np.maximum(relief.at(unseen.height, x_at, y_at, 0.0), 0.0)
    fresh = relief.at(unseen.cells, x_at, y_at, False)
    gains = (fresh & (drape(ground, np.full(len(poses), level)) - ground < NEAR)).sum(axis=(1, 2)) * GRID**2
    little = max(LITTLE[0], LITTLE[1] * relief.felt_area)
    held = np.where(slips, 0.0, gains)
    best = int((held if held.max() >= little else gains).argmax())
    if gains[best] < little:
        return None
    at_x, at_y, yaw = (float(v) for v in poses[best])
    return LookFrom(at_x, at_y, yaw, float(gains[best]))


def _poses(
    relief: Relief,
    unseen: Hidden,
    x: tuple[float, float],
    y: tuple[float, float],
) -> Array:
    """Return poses (k, 3) to compare: over and around the middle of what was felt, and over what was not."""
    felt = relief.place(np.argwhere(relief.felt))
    middle = (felt.min(axis=0) + felt.max(axis=0)) / 2
    around = middle + np.array([(a, b) for a in OFFSETS for b in OFFSETS])
    rim = relief.place(np.argwhere(unseen.cells))
    places = np.concatenate([around, rim[:: max(1, len(rim) // MOST)]])
    inside = (places[:, 0] >= x[0]) & (places[:, 0] <= x[1]) & (places[:, 1] >= y[0]) & (places[:, 1] <= y[1])
    poses = np.array([(*place, yaw) for place in places[inside] for yaw in (0.0, np.pi / 2)]).reshape(-1, 3)
    for before in relief.poses:
        far = np.hypot(*(poses[:, :2] - before[:2]).T) > TAKEN[0]
        turned = np.abs((poses[:, 2] - before[2] + np.pi / 2) % np.pi - np.pi / 2) > TAKEN[1]
        poses = poses[far | turned]
    return poses


def _grid(poses: Array, length: float, width: float) -> tuple[Array, Array]:
    """Return x and y (k, n, m), m, of the nodes of the sheet and of the fingers beyond its clamps."""
    u = (np.arange(round(width / GRID)) + 0.5) * GRID - width / 2
    ends = length / 2 + FINGER
    v = (np.arange(round(2 * ends / GRID)) + 0.5) * GRID - ends
    c, s = np.cos(poses[:, 2])[:, None, None], np.sin(poses[:, 2])[:, None, None]
    x, y = poses[:, 0][:, None, None], poses[:, 1][:, None, None]
    return x + c * u[:, None] - s * v, y + s * u[:, None] + c * v


def _in_the_way(relief: Relief, level: float) -> npt.NDArray[np.bool_]:
    """Return over which cells no finger may stand at a level, m: where the object is, or may be as its flanks fall off."""
    from scipy.ndimage import distance_transform_edt

    felt = relief.felt
    far, nearest = distance_transform_edt(~felt, return_indices=True)
    flank = np.maximum(relief.height[tuple(nearest)] - level, 0.0) / FLANK + MARGIN
    return np.asarray((far * relief.cell < flank) & (relief.height[tuple(nearest)] > level - MARGIN))
