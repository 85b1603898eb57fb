"""A height map of what a hand has felt from above: where it touched, where its membrane hung free, what it has not seen.

A membrane that is pressed from above lies on the object or above it. The lowest that any press saw it at a place is thus a
bound on the object there, its `ceiling`. Where it stays as the hand rises, and is not bent as only a free one is, it is in contact,
and shows the object's height. A contact that another press undercuts was none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import Pose
from stretch_bt.perception.clouds.cloud import Cloud
from stretch_bt.perception.clouds.support import supported
from stretch_bt.perception.deprojection import to_world
from stretch_bt.perception.types import FloatArray
from stretch_bt.units import Area, Length

__all__ = ["CELL", "Relief", "View", "add_view", "carved", "turn_of", "view_of"]

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

CELL = 1e-3  # m
TOLERANCE = 0.35e-3  # m by which a contact may stand above the ceiling: what averaged frames leave of a camera's error
CLAMP = 6e-3  # m from the clamps within which the membrane is bent by them, and no contact is believed
STAYS = (0.04e-3, 0.15e-3)  # m, at least and at most, by which contact may seem to rise
LAG = 0.02  # share of the hand's rise by which it may besides
SURE = 3.0  # standard deviations of a rise
HIGHEST, SPRING = 60, 0.3e-3  # cells that surely touch, and m by which an object under them springs back at most
LEAST_RISE = 0.8e-3  # m
HANGS = 2e-3  # m below the hand to which a membrane hangs at most; what a camera sees beyond its sides is lower
RIM = 2  # cells from the rim of a contact within which it may be none
MOVED = 1.2e-3  # m by which two views of one place disagree that neither noise nor a slack membrane explains
WRONG, SHARE = 60, 0.15  # cells that disagree, and their share of those seen twice, from which the object has moved
TWICE = 2  # views, as soon as there are more, that must have felt what no other may pierce
SAME = (2e-3, 0.2)  # m and rad: two poses that are nearer are one
FEWEST = 25  # cells or points of a part that is worth telling


@dataclass(frozen=True, slots=True)
class View:
    """What one press shows, by cell: (n, 2) int64 indices, heights (n,), m, whether the membrane touched, or hung for sure.

    It hangs for sure where it stays as the hand rises, held up by what it touches elsewhere. `cut` tells that the contact goes
    on up to a clamp of the hand; `pose` is its x, y, m, and turn, rad.
    """

    cells: npt.NDArray[np.int64]
    heights: Array
    touched: Mask
    hung: Mask
    cut: bool = False
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Relief:
    """A height map of the world in square cells `cell` m wide; the cell [i, j] begins at (x, y) = (origin + [i, j]) * cell.

    `ceiling` (n, m), m, world z, is the lowest that the membrane was seen, infinite where it never was. `height` (n, m), m,
    is the mean height of the contacts there, `weight` (n, m) how many they are, and `hung` (n, m) how often the membrane hung
    there for sure while it stayed. `views` counts the presses, and `poses` are
    the x and y, m, and the turn about the vertical, rad, of the hand at each. `second` (n, m), m, is the lowest of all presses but
    the one that is lowest there, from another pose than that; None where nothing tells.
    """

    origin: tuple[int, int]
    ceiling: Array
    height: Array
    weight: Array
    hung: Array
    cell: Length = CELL
    views: int = 0
    poses: tuple[tuple[float, float, float], ...] = ()
    second: Array | None = None

    @property
    def felt(self) -> Mask:
        """Where the object's surface is known: (n, m) bool."""
        return (self.weight > self.hung) & (self.height - self.ceiling <= TOLERANCE)

    @property
    def felt_area(self) -> Area:
        """Area felt, as seen from above, m^2."""
        return float(self.felt.sum()) * self.cell**2

    @property
    def top(self) -> Length:
        """World height of the highest place felt, m.

        Raises
        ------
        NoContact
            Nothing was felt.
        """
        felt = self.felt
        if not felt.any():
            raise NoContact("nothing was felt yet")
        return float(np.percentile(self.height[felt], 99))

    @property
    def summit(self) -> tuple[float, float, float] | None:
        """World place, x, y and height, m, of the highest surface felt, None where nothing was."""
        from scipy.ndimage import uniform_filter

        felt = self.felt
        if not felt.any():
            return None
        near = uniform_filter(felt.astype(float), 5, mode="constant")
        mean = uniform_filter(np.where(felt, self.height, 0.0), 5, mode="constant") / np.maximum(near, 1e-9)
        i, j = np.unravel_index(np.where(felt, mean - 1e-2 * (near < near.max() / 2), -np.inf).argmax(), felt.shape)
        x, y = self.place(np.array([[i, j]]))[0]
        return float(x), float(y), float(mean[i, j])

    @property
    def pieces(self) -> int:
        """How many parts the felt surface is in, of those that are larger than a few cells."""
        from scipy.ndimage import binary_closing, label

        parts, count = label(
            binary_closing(np.pad(self.felt, 2), np.ones((3, 3), dtype=bool)), np.ones((3, 3), dtype=np.int64)
        )
        return int((np.bincount(parts.ravel())[1 : count + 1] > FEWEST).sum())

    def at(self, values: npt.NDArray[Any], x: Array, y: Array, outside: Any) -> npt.NDArray[Any]:
        """Return the values, one a cell, of the cells in which places x and y, m, world, of any one shape lie; `outside` beside the map."""
        i, j = (np.floor(at / self.cell).astype(np.int64) - o for at, o in zip((x, y), self.origin, strict=True))
        n, m = values.shape
        known = (i >= 0) & (i < n) & (j >= 0) & (j < m)
        return np.asarray(np.where(known, values[np.clip(i, 0, n - 1), np.clip(j, 0, m - 1)], outside))

    def holds(self, points: Array) -> Mask:
        """Return which points (n, 3), m, world, lie on the surface that was felt."""
        x, y, z = points.T
        height = self.at(np.where(self.felt, self.height, np.inf), x, y, np.inf)
        return np.asarray(np.abs(z - height) < MOVED)

    def place(self, cells: npt.NDArray[np.int64]) -> Array:
        """Return the middle, x and y, m, of cells (n, 2) that are told by their index in the map."""
        return np.asarray((cells + np.asarray(self.origin) + 0.5) * self.cell)


def view_of(
    deep: FloatArray,
    shallow: FloatArray,
    *,
    deep_pose: Pose,
    shallow_pose: Pose,
    half_length: float,
    cell: float = CELL,
) -> View:
    """Return what a press shows in the cells of the world, from the membrane at two heights of the hand.

    Where the membrane stays while the hand rises it lies on the object; where it hangs free it rises with the hand.

    Parameters
    ----------
    deep, shallow : (h, w, 3) float, m, membrane frame
        Points of the membrane, NaN where unknown, with the hand lower and higher.
    deep_pose, shallow_pose : Pose
        Of the hand in the world, then.
    half_length : float, m
        From the middle of the membrane to a clamp.

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
            f"the hand rose by {rise * 1e3:.2f} mm between the frames; to tell contact it takes {LEAST_RISE * 1e3:g} mm"
        )
    low, clear = _placed(deep, deep_pose, half_length)
    high, _ = _placed(shallow, shallow_pose, half_length)
    cells, which, count = np.unique(_index(low, cell), axis=0, return_inverse=True, return_counts=True)
    heights, free = _means(which.ravel(), low[:, 2], count), _means(which.ravel(), clear, count) > 0.99
    above = _heights_at(cells, high, cell)
    stayed = _stayed(heights, above - heights, rise)
    whole = count >= 0.3 * np.median(count)
    cut = int((stayed & ~free).sum()) > FEWEST
    at = (*deep_pose.position[:2], turn_of(deep_pose))
    touched, hung = (stayed & free & told for told in _lying(cells, heights, stayed, at[2], cell))
    return View(cells[whole], heights[whole], touched[whole], hung[whole], cut, at)


def _stayed(heights: Array, up: Array, rise: float) -> Mask:
    """Return where the membrane is in contact, by heights (n,), m, and by how much it rises (n,), m, as the hand does.

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
        raise NoContact("the frame has no valid pixel")
    clear = half_length - np.abs(points[:, 1]) > CLAMP
    return to_world(points, pose), clear.astype(np.float64)


def _index(points: Array, cell: float) -> npt.NDArray[np.int64]:
    return np.floor(points[:, :2] / cell).astype(np.int64)


def _means(which: npt.NDArray[np.int64], values: Array, count: npt.NDArray[np.int64]) -> Array:
    return np.bincount(which, values) / count


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


def add_view(view: View, relief: Relief | None = None, *, cell: float = CELL) -> Relief:
    """Return the map with one more view in it.

    Raises
    ------
    IllConditioned
        The view contradicts the map by more than its noise over many cells: the membrane is well below a surface that was
        felt, or in contact well above where it hung before. The object moved or gave way; nothing is averaged.
    InvalidInput
        The map has cells of another width.
    """
    if relief is None:
        low, high = view.cells.min(axis=0), view.cells.max(axis=0) + 1
        shape = (int(high[0] - low[0]), int(high[1] - low[1]))
        nothing = np.zeros(shape)
        free = np.full(shape, np.inf)
        relief = Relief((int(low[0]), int(low[1])), free, nothing, nothing, nothing, cell, second=free)
    if relief.cell != cell:
        raise InvalidInput(f"the map has cells of {relief.cell} m, the view of {cell} m")
    relief = _grown(relief, view.cells)
    _check_still(relief, view)
    i, j = (view.cells - relief.origin).T
    ceiling, height = relief.ceiling.copy(), relief.height.copy()
    weight, hung = relief.weight.copy(), relief.hung.copy()
    hung[i, j] += view.hung
    ceiling[i, j] = np.minimum(ceiling[i, j], view.heights)
    second = relief.second
    if second is not None and not any(
        math.dist(view.pose[:2], at[:2]) < SAME[0] and abs(view.pose[2] - at[2]) < SAME[1] for at in relief.poses
    ):
        second = second.copy()
        second[i, j] = np.minimum(second[i, j], np.maximum(relief.ceiling[i, j], view.heights))
    t, u, found = i[view.touched], j[view.touched], view.heights[view.touched]
    undercut = (weight[t, u] > 0) & (height[t, u] - found > TOLERANCE)
    weight[t[undercut], u[undercut]] = 0.0
    counts = (weight[t, u] == 0) | (found - height[t, u] <= TOLERANCE)
    t, u, found = t[counts], u[counts], found[counts]
    weight[t, u] += 1.0
    height[t, u] += (found - height[t, u]) / weight[t, u]
    return replace(
        relief,
        ceiling=ceiling,
        height=height,
        weight=weight,
        hung=hung,
        views=relief.views + 1,
        poses=(*relief.poses, view.pose),
        second=second,
    )


def carved(cloud: Cloud, relief: Relief) -> Cloud:
    """Return a cloud of the world without what later presses undercut, or showed to be no contact."""
    return cloud.part(relief.holds(cloud.points))


def _grown(relief: Relief, cells: npt.NDArray[np.int64]) -> Relief:
    """Return the map, large enough for the cells."""
    origin, shape = np.array(relief.origin), np.array(relief.ceiling.shape)
    before = np.maximum(origin - cells.min(axis=0), 0)
    after = np.maximum(cells.max(axis=0) + 1 - origin - shape, 0)
    if not (before.any() or after.any()):
        return relief
    room = list(zip(before.tolist(), after.tolist(), strict=True))
    start = (origin - before).tolist()
    return replace(
        relief,
        origin=(start[0], start[1]),
        ceiling=np.pad(relief.ceiling, room, constant_values=np.inf),
        height=np.pad(relief.height, room),
        weight=np.pad(relief.weight, room),
        hung=np.pad(relief.hung, room),
        second=None if relief.second is None else np.pad(relief.second, room, constant_values=np.inf),
    )


def _check_still(relief: Relief, view: View) -> None:
    """Raise IllConditioned where a view cannot be of the object that the map shows."""
    from scipy.ndimage import binary_erosion

    if not relief.views:
        return
    i, j = (view.cells - relief.origin).T
    seen, touched = np.full(relief.ceiling.shape, np.nan), np.zeros(relief.ceiling.shape, dtype=bool)
    seen[i, j], touched[i, j] = view.heights, view.touched
    known = relief.felt & (
        relief.weight >= min(relief.views - 1, TWICE)
    )  # what one of several views shows may have hung there
    inner = binary_erosion(known, iterations=RIM)
    pierced = inner & (relief.height - seen > MOVED)
    raised = binary_erosion(touched, iterations=RIM) & (seen - relief.ceiling > MOVED)
    twice = int((inner & np.isfinite(seen)).sum())
    again = relief.felt & touched & (np.abs(seen - relief.height) < TOLERANCE)
    risen = int(
        raised.sum()
    )  # a flat membrane that hangs may seem to touch; an object that rose is felt nowhere as before
    wrong = int(pierced.sum()) + (risen if risen > again.sum() else 0)
    if wrong > max(WRONG, SHARE * twice):
        worst = float(np.nanmax(np.abs(np.where(pierced, relief.height, relief.ceiling) - seen)[pierced | raised]))
        raise IllConditioned(
            f"the object moved or gave way since the press before: {wrong} mm^2 of its surface disagree with what was felt, "
            f"by up to {worst * 1e3:.1f} mm; hold it fast, or press it more lightly, and begin again"
        )
