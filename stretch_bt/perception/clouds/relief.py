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

from stretch_bt.brief import BriefRepr
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception.clouds.cloud import Cloud
from stretch_bt.perception.clouds.seen import CELL, FEWEST, Array, CellView, Mask
from stretch_bt.units import Area, Length

__all__ = ["CELL", "Relief", "add_view", "carved"]

TOLERANCE = 0.35e-3  # m that a contact may stand above the ceiling: a camera's error that remains in averaged frames
RIM = 2  # cells from the rim of a contact within which it may be none
MOVED = 1.2e-3  # m, difference of two views of one place that neither noise nor a slack membrane explains
WRONG, SHARE = 60, 0.15  # cells that disagree, and their share of those seen twice, from which the object has moved
TWICE = 2  # views, as soon as there are more, that must have felt what no other may pierce
SAME = (2e-3, 0.2)  # m and rad: two poses that are nearer are one
ROOM = 0.020  # m of the map around all cells seen, where an object that reaches the rim may go on: more than a finger is beyond a clamp


@dataclass(frozen=True, slots=True, repr=False)
class Relief(BriefRepr):
    """A height map of the world in square cells `cell` m wide; the cell [i, j] begins at (x, y) = (origin + [i, j]) * cell.

    `ceiling` (n, m), m, world z, is the lowest that the membrane was seen, infinite where it never was. `height` (n, m), m,
    is the mean height of the contacts there, `weight` (n, m) how many they are, and `hung` (n, m) how often the membrane hung
    there for sure while it stayed. `views` counts the presses, and `poses` are
    the x and y, m, and the turn about the vertical, rad, of the hand at each. `second` (n, m), m, is the second lowest of the
    presses there, from another pose than the lowest; None where it is not known.
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
        """Where the object's surface was felt: (n, m) bool."""
        return (self.weight > self.hung) & (self.height - self.ceiling <= TOLERANCE)

    @property
    def unknown(self) -> Mask:
        """Where no membrane has been, beyond all that was seen: (n, m) bool."""
        from scipy.ndimage import binary_fill_holes

        return ~np.asarray(binary_fill_holes(np.isfinite(self.ceiling)))

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
            raise NoContact("nothing was felt yet: no height is known; press the object first")
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
        """Return the middle, x and y, m, of cells (n, 2), given by their indices in the map."""
        return np.asarray((cells + np.asarray(self.origin) + 0.5) * self.cell)


def add_view(view: CellView, relief: Relief | None = None, *, cell: float = CELL) -> Relief:
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
    beyond = round(ROOM / cell)
    relief = _grown(relief, np.concatenate([view.cells - beyond, view.cells + beyond]))
    _check_still(relief, view)
    i, j = (view.cells - relief.origin).T
    ceiling, height = relief.ceiling.copy(), relief.height.copy()
    weight, hung = relief.weight.copy(), relief.hung.copy()
    hung[i, j] += view.hung
    ceiling[i, j] = np.minimum(ceiling[i, j], view.heights)
    second = relief.second
    if second is not None and not any(
        math.dist(view.pose[:2], at[:2]) < SAME[0] and _apart(view.pose[2], at[2]) < SAME[1] for at in relief.poses
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


def _apart(turn: float, other: float) -> float:
    """Return the angle between two turns, rad: after half a turn the membrane is the same."""
    return abs(math.remainder(turn - other, math.pi))


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


def _check_still(relief: Relief, view: CellView) -> None:
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
