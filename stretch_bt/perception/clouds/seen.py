"""What one press shows: where the membrane touched, where it hung free, by what stays as the hand rises."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, NoContact
from stretch_bt.frames import Pose
from stretch_bt.perception.cells import cells_of
from stretch_bt.perception.clouds.support import supported
from stretch_bt.perception.deprojection import to_world
from stretch_bt.perception.types import FloatArray

__all__ = ["CELL", "FEWEST", "Array", "CellView", "Mask", "turn_of", "view_of"]

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

CELL = 1e-3  # m
CLAMP = 6e-3  # m from the clamps within which the membrane is bent by them, and no contact is believed
STAYS = (0.04e-3, 0.15e-3)  # m, least and largest tolerance of the rise of a contact
LAG = 0.02  # share of the hand's rise that is added to this tolerance
SURE = 3.0  # standard deviations of a rise
HIGHEST, SPRING = 60, 0.3e-3  # cells that surely touch, and m that an object under them springs back at most
LEAST_RISE = 0.8e-3  # m
HANGS = 2e-3  # m, largest sag of a membrane below the hand; beyond its sides a camera sees lower things
FEWEST = 25  # cells or points of a part that is large enough to count


@dataclass(frozen=True, slots=True)
class CellView:
    """What one press shows, by cell: (n, 2) int64 indices, heights (n,), m, whether the membrane touched, or hung for sure.

    It hangs for sure where it stays as the hand rises, held up by what it touches elsewhere. `cut` says that the contact goes
    on up to a clamp of the hand; `pose` is its x, y, m, and turn, rad.
    """

    cells: npt.NDArray[np.int64]
    heights: Array
    touched: Mask
    hung: Mask
    cut: bool = False
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)


def view_of(
    deep: FloatArray,
    shallow: FloatArray,
    *,
    deep_pose: Pose,
    shallow_pose: Pose,
    half_length: float,
    cell: float = CELL,
) -> CellView:
    """Return what a press shows in the cells of the world, from the membrane at two heights of the hand.

    Where the membrane stays while the hand rises it lies on the object; where it hangs free it rises with the hand.

    Parameters
    ----------
    deep, shallow : (h, w, 3) float, m, membrane frame
        Points of the membrane, NaN where unknown, with the hand lower and higher.
    deep_pose, shallow_pose : Pose
        Poses of the hand in the world, then.
    half_length : float, m
        Distance from the middle of the membrane to a clamp.

    Raises
    ------
    NoContact
        A frame has no valid pixel.
    IllConditioned
        The hand hardly rose between the frames.
    """
    rise = shallow_pose.height - deep_pose.height
    if rise < LEAST_RISE:
        raise IllConditioned(
            f"the hand rose by {rise * 1e3:.2f} mm between the frames; to show contact it takes"
            f" {LEAST_RISE * 1e3:g} mm; raise the hand further between them"
        )
    low, clear = _placed(deep, deep_pose, half_length)
    high, _ = _placed(shallow, shallow_pose, half_length)
    found = cells_of(_index(low, cell))
    cells, heights, free = found.cells, found.means(low[:, 2]), found.means(clear) > 0.99
    above = _heights_at(cells, high, cell)
    stayed = _stayed(heights, above - heights, rise)
    whole = found.counts >= 0.3 * np.median(found.counts)
    cut = int((stayed & ~free).sum()) > FEWEST
    at = (*deep_pose.position[:2], turn_of(deep_pose))
    touched, hung = (stayed & free & told for told in _lying(cells, heights, stayed, at[2], cell))
    return CellView(cells[whole], heights[whole], touched[whole], hung[whole], cut, at)


def _stayed(heights: Array, up: Array, rise: float) -> Mask:
    """Return where the membrane is in contact, by its heights (n,), m, and its rises (n,), m, as the hand rises.

    Its highest places are; an object that gives way rises with them. That nothing else rises less shows the noise.
    """
    highest = up[heights > np.partition(heights, -HIGHEST)[-HIGHEST]] if len(heights) > HIGHEST else up
    begin = float(np.clip(np.median(highest), -SPRING, SPRING)) if len(highest) else 0.0
    below = begin - up[(up < begin) & (up > begin - STAYS[1])]
    noise = float(np.sqrt(np.mean(below**2))) if len(below) else 0.0
    return np.asarray(up < begin + float(np.clip(SURE * noise, *STAYS)) + LAG * rise)


def _lying(cells: npt.NDArray[np.int64], heights: Array, stayed: Mask, turn: float, cell: float) -> tuple[Mask, Mask]:
    """Return in which of the cells the membrane lies on something, and in which it hangs, by its shape."""
    low = cells.min(axis=0)
    at = tuple((cells - low).T)
    z, stays = np.full(tuple(cells.max(axis=0) - low + 1), np.nan), np.zeros(tuple(cells.max(axis=0) - low + 1), bool)
    z[at], stays[at] = heights, stayed
    lies, hangs = supported(z, stays, turn=turn, cell=cell)
    return lies[at], hangs[at]


def turn_of(pose: Pose) -> float:
    """Return the turn of a hand about the vertical, rad."""
    matrix = pose.matrix()
    return math.atan2(matrix[1, 0], matrix[0, 0])


def _placed(surface: FloatArray, pose: Pose, half_length: float) -> tuple[Array, Array]:
    """Return points in the world (n, 3), m, and which lie clear of the clamps."""
    points = np.asarray(surface, np.float64).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1) & (np.nan_to_num(points[:, 2]) > -HANGS)]
    if not len(points):
        raise NoContact("the frame has no valid pixel: nothing is seen; look at the camera")
    clear = half_length - np.abs(points[:, 1]) > CLAMP
    return to_world(points, pose), clear.astype(np.float64)


def _index(points: Array, cell: float) -> npt.NDArray[np.int64]:
    return np.floor(points[:, :2] / cell).astype(np.int64)


def _heights_at(cells: npt.NDArray[np.int64], points: Array, cell: float) -> Array:
    """Return the mean height of the points in each of the cells, infinite where there are none."""
    low = cells.min(axis=0)
    size = cells.max(axis=0) - low + 1
    index = _index(points, cell) - low
    index = index[inside] if not (inside := ((index >= 0) & (index < size)).all(axis=1)).all() else index
    flat = index @ [size[1], 1]
    total = np.bincount(flat, points[inside, 2], minlength=int(size.prod()))
    count = np.bincount(flat, minlength=int(size.prod()))
    at = (cells - low) @ [size[1], 1]
    return np.where(count[at] > 0, total[at] / np.maximum(count[at], 1), np.inf)
