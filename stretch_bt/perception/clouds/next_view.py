"""Where to press next: the place and turn of the hand that is expected to show most of what was not felt yet."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
TURNS = np.radians([0.0, 45.0, 90.0, 135.0])  # of the hand
ACROSS = (-0.020, 0.0, 0.020)  # m from the middle of the object, across the hand
ALONG, STEP, COARSE = 0.040, 1e-3, 10  # m along the hand; between places, m; and each how many of them is tried
MOST = 12  # places over what was not seen that are tried beside those
FINGER = 0.015  # m, of the fingers beyond the clamps
FLANK, MARGIN = np.tan(np.radians(65.0)), 3e-3  # of the object beside what was felt, and m; no finger goes there
LITTLE = (4e-6, 0.005)  # m^2, and share of the area felt: a press that is expected to show less is not worth it
BESIDE = 8e-3  # m from a clamp within which nothing is felt: it bends the membrane, and the camera hardly sees it
SIDE = 2  # nodes along each free side of the sheet: one that lies over the object may slip off it
MISSED = 0.5  # factor on a place's worth for each press that was to show it and did not: the surface there is steeper than expected
RIM = 4e-3  # m from the rim of what was seen within which a surface that was felt may go on beyond it
TAKEN = (5e-3, np.radians(30.0))  # m and rad: as near to a pose that was used, another shows nothing new


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
    tried: Sequence[tuple[float, float, float]] = (),
) -> LookFrom | None:
    """Return the pose whose press is expected to show most unseen surface, or None where none shows more than a little.

    A surface that may go on unseen is taken to fall off at the steepest slope that is looked for. A sheet is hung over it from
    each of many poses, its hand `depth` below the top, and the unseen cells that it touches count: in truth the membrane then
    either feels a surface there or hangs below it, and carves it away. It counts as much as upper surface is likely there, and less
    where earlier presses were to show it and did not. Poses at which the object lies under a free side of the sheet come last.

    Parameters
    ----------
    relief : Relief
        The map so far; a pose that was pressed from is not returned again.
    depth : float, m
        Depth of the hand below the highest place felt.
    length, width : float, m
        Size of the membrane, from clamp to clamp and across.
    x, y : (least, most), m
        Where the hand may go.
    tried : sequence of (x, y, turn), m and rad
        Other poses not to return.

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
    if not unseen.cells.any():
        return None
    level = max(top - depth, 0.0)
    way = _Way(relief, _in_the_way(relief, level), length, width)
    poses = _untaken(np.concatenate([_around(relief, way), _over(relief, unseen, way)]), [*relief.poses, *tried])
    inside = (poses[:, 0] >= x[0]) & (poses[:, 0] <= x[1]) & (poses[:, 1] >= y[0]) & (poses[:, 1] <= y[1])
    poses = poses[inside]
    if not len(poses):
        return None
    slips = way.slips(poses)
    before = np.unique(np.array(relief.poses).reshape(-1, 3), axis=0)
    shown, x_at, y_at = _shown(relief, unseen, np.concatenate([before, poses]), level, length, width)
    worth = relief.at(_worth(relief, shown, x_at, y_at, len(before)), x_at[len(before) :], y_at[len(before) :], 1.0)
    likely = relief.at(unseen.chance, x_at[len(before) :], y_at[len(before) :], 0.0)
    gains = (shown[len(before) :] * worth * likely).sum(axis=(1, 2)) * GRID**2
    little = max(LITTLE[0], LITTLE[1] * relief.felt_area)
    held = np.where(slips, 0.0, gains)
    best = int((held if held.max() >= little else gains).argmax())
    if gains[best] < little:
        return None
    at_x, at_y, yaw = (float(v) for v in poses[best])
    return LookFrom(at_x, at_y, yaw, float(gains[best]))


def _shown(
    relief: Relief, unseen: Hidden, poses: Array, level: float, length: float, width: float
) -> tuple[npt.NDArray[np.bool_], Array, Array]:
    """Return what sheets hung from poses (k, 3) are expected to touch of the unseen, (k, n, m), and the places of their nodes, m."""
    reach = round(FINGER / GRID)
    x_at, y_at = (at[:, :, reach:-reach] for at in _grid(poses, length, width))
    ground = np.maximum(relief.at(unseen.height, x_at, y_at, 0.0), 0.0)
    fresh = relief.at(unseen.cells, x_at, y_at, False)
    fresh[:, :, np.abs((np.arange(x_at.shape[2]) + 0.5) * GRID - length / 2) > length / 2 - BESIDE] = False
    return fresh & (drape(ground, np.full(len(poses), level)) - ground < NEAR), x_at, y_at


def _worth(relief: Relief, shown: npt.NDArray[np.bool_], x_at: Array, y_at: Array, count: int) -> Array:
    """Return what each cell (n, m) counts: less with each of the first `count` presses that was to show it and did not."""
    from scipy.ndimage import binary_dilation

    n, m = relief.ceiling.shape
    worth = np.ones((n, m))
    for k in range(count):
        i = np.floor(x_at[k][shown[k]] / relief.cell).astype(np.int64) - relief.origin[0]
        j = np.floor(y_at[k][shown[k]] / relief.cell).astype(np.int64) - relief.origin[1]
        inside = (i >= 0) & (i < n) & (j >= 0) & (j < m)
        missed = np.zeros((n, m), dtype=bool)
        missed[i[inside], j[inside]] = True
        worth[binary_dilation(missed, np.ones((3, 3), dtype=bool))] *= MISSED
    return worth


@dataclass(frozen=True, slots=True)
class _Way:
    """Where the fingers of a hand may stand, and the free sides of its membrane, of a length and a width, m: `under` are the cells of the object."""

    relief: Relief
    under: npt.NDArray[np.bool_]
    length: float
    width: float

    def clear(self, poses: Array) -> npt.NDArray[np.bool_]:
        """Return at which poses (k, 3) neither clamps nor fingers are over the object."""
        under, reach = self._beneath(poses), round(FINGER / GRID)
        return np.asarray(~(under[:, :, :reach].any(axis=(1, 2)) | under[:, :, -reach:].any(axis=(1, 2))))

    def slips(self, poses: Array) -> npt.NDArray[np.bool_]:
        """Return at which poses (k, 3) a free side is over the object."""
        under = self._beneath(poses)
        return np.asarray(np.concatenate([under[:, :SIDE], under[:, -SIDE:]], axis=1).any(axis=(1, 2)))

    def _beneath(self, poses: Array) -> npt.NDArray[np.bool_]:
        x, y = _grid(poses, self.length, self.width)
        return self.relief.at(self.under, x, y, False)


def _around(relief: Relief, way: _Way) -> Array:
    """Return poses (k, 3) over and around the middle of what was felt, up to where a finger comes as near to it as may be.

    The nearer a clamp, the steeper the membrane beside it.
    """
    felt = relief.place(np.argwhere(relief.felt))
    middle = (felt.min(axis=0) + felt.max(axis=0)) / 2
    count = round(ALONG / STEP)
    yaw, across, k = np.meshgrid(TURNS, ACROSS, np.arange(-count, count + 1), indexing="ij")
    along = STEP * k
    at_x = middle[0] + np.cos(yaw) * across - np.sin(yaw) * along
    at_y = middle[1] + np.sin(yaw) * across + np.cos(yaw) * along
    poses = np.stack([at_x, at_y, yaw], axis=-1)
    clear = way.clear(poses.reshape(-1, 3)).reshape(yaw.shape)
    beyond = np.pad(clear, ((0, 0), (0, 0), (1, 1)))
    nearest = clear & np.where(k > 0, ~beyond[:, :, 2:], ~beyond[:, :, :-2])
    return np.asarray(poses[nearest | (clear & (k % COARSE == 0))])


def _over(relief: Relief, unseen: Hidden, way: _Way) -> Array:
    """Return clear poses (k, 3) over what was not felt."""
    rim = relief.place(np.argwhere(unseen.cells))
    places = rim[:: max(1, len(rim) // MOST)]
    poses = np.array([(*place, yaw) for place in places for yaw in TURNS]).reshape(-1, 3)
    return np.asarray(poses[way.clear(poses)])


def _untaken(poses: Array, taken: Iterable[tuple[float, float, float]]) -> Array:
    """Return the poses that are not near to one that was pressed from."""
    for before in taken:
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
    """Return over which cells no finger may stand at a level, m: where the object is, or may be as its flanks fall off.

    One that was felt up to the rim of what was seen may go on straight beyond it, however far.
    """
    from scipy.ndimage import distance_transform_edt

    felt = relief.felt
    far, nearest = distance_transform_edt(~felt, return_indices=True)
    flank = np.maximum(relief.height[tuple(nearest)] - level, 0.0) / FLANK + MARGIN
    rim = distance_transform_edt(relief.unknown, return_distances=False, return_indices=True)
    along = relief.unknown & (far * relief.cell <= RIM)[tuple(rim)]
    return np.asarray((along | (far * relief.cell < flank)) & (relief.height[tuple(nearest)] > level - MARGIN))
