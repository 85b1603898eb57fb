"""How much of an object's upper surface the presses show, and where more of it may lie that no hand has reached yet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.clouds.relief import TOLERANCE, Relief
from stretch_bt.perception.clouds.told import told

__all__ = ["SLOPE", "WIDTH", "Hidden", "coverage", "hidden"]

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

#: tangent of the steepest surface that is looked for; the map rounds off the last degrees to 45
SLOPE = float(np.tan(np.radians(40.0)))
WIDTH = 6e-3  # m that a surface is expected to go on beyond what is shown of it
STEP = (1.0, np.sqrt(2.0))
UPPER = np.radians(45.0)  # a steeper surface is not looked for
BASE = 2  # cells on each side that the slope of a surface is taken over


@dataclass(frozen=True, slots=True)
class Hidden:
    """Where a surface may go on unseen: the cells, (n, m) bool, and its height if it falls as `SLOPE`, (n, m), m.

    In a cell whose surface is shown, `height` is the height of that surface; where nothing is expected it is minus infinity.
    `chance` (n, m) is the probability of upper surface in each of the cells, 0 in all others.
    """

    cells: Mask
    height: Array
    chance: Array

    @property
    def told(self) -> Mask:
        """The cells (n, m) in which the surface is shown."""
        return np.isfinite(self.height) & ~self.cells


def hidden(relief: Relief) -> Hidden:
    """Return where the upper surface may go on beyond what is shown of it.

    From each place that was felt a surface may fall off at `SLOPE`. Where the membrane hung below that, it is carved away:
    the object has none there. It goes on by at most `WIDTH`, and by at most half the width of the felt part: more is looked
    for once the next press has shown that there is more.
    """
    felt, known = relief.felt, told(relief)
    start = np.where(felt, relief.height, -np.inf)
    room = np.where(felt, _half_width(felt, relief.cell) + relief.cell, -np.inf)
    height, reach = start.copy(), np.minimum(room, WIDTH)
    for _ in range(round(WIDTH / relief.cell)):
        height, reach = _spread(height, reach, SLOPE * relief.cell, relief.cell)
    height[known] = np.where(felt, relief.height, relief.ceiling)[known]
    cells = ~known & np.isfinite(height) & (height > 0) & (relief.ceiling - height > TOLERANCE)
    height = np.where(cells | known, height, -np.inf)
    return Hidden(cells, height, np.where(cells, _chance(relief, np.where(known, height, np.nan)), 0.0))


def coverage(relief: Relief, unseen: Hidden | None = None) -> float:
    """Return the share of the upper surface that is shown, as seen from above; a hidden cell counts by its chance."""
    unseen = hidden(relief) if unseen is None else unseen
    known = int(unseen.told.sum())
    return known / (known + float(unseen.chance.sum())) if known else 0.0


def _chance(relief: Relief, surface: Array) -> Array:
    """Return the probability (n, m) that an upper surface goes on beyond a shown one (n, m), m, NaN elsewhere.

    It falls off at least as steeply as the membrane above it, and as the shown surface at its rim, as a convex one does. All
    steeper angles up to a wall are taken as equally likely. Where no membrane has been it surely goes on.
    """
    from scipy.ndimage import distance_transform_edt

    known = np.isfinite(surface)
    if not known.any():
        return np.zeros(surface.shape)
    far, near = distance_transform_edt(~known, return_indices=True)
    fall = np.maximum(surface[tuple(near)] - relief.ceiling, 0.0)
    above = np.arctan2(fall, np.maximum(far, 1.0) * relief.cell)
    least = np.maximum(above, _angles(surface, relief.cell)[tuple(near)])
    likely = np.clip((UPPER - least) / (np.pi / 2 - least), 0.0, 1.0)
    return np.where(relief.unknown, 1.0, likely)


def _angles(surface: Array, cell: float) -> Array:
    """Return the inclination (n, m), rad, of a surface (n, m), m, NaN where there is none; at its rim it is taken from one side."""
    from scipy.ndimage import uniform_filter

    square = np.zeros(surface.shape)
    for axis in (0, 1):
        room = [(BASE, BASE) if a == axis else (0, 0) for a in (0, 1)]
        steps = np.diff(np.pad(surface, room, constant_values=np.nan), axis=axis)
        steps = np.lib.stride_tricks.sliding_window_view(steps, 2 * BASE, axis=axis)
        count = np.isfinite(steps).sum(axis=-1)
        square += (np.nansum(steps, axis=-1) / np.maximum(count, 1) / cell) ** 2
    known = np.isfinite(surface)
    near = uniform_filter(known.astype(float), 3)
    mean = uniform_filter(np.where(known, np.arctan(np.sqrt(square)), 0.0), 3) / np.maximum(near, 1e-9)
    return np.where(known, mean, 0.0)


def _half_width(felt: Mask, cell: float) -> Array:
    """Return how wide the part is to which each cell belongs: the largest distance to its rim nearby, m."""
    from scipy.ndimage import distance_transform_edt, maximum_filter

    inside = distance_transform_edt(np.pad(felt, 1))[1:-1, 1:-1] * cell
    return np.asarray(maximum_filter(inside, size=15))


def _spread(height: Array, reach: Array, fall: float, cell: float) -> tuple[Array, Array]:
    """Return heights and the reach that is left, spread by a cell to each side and corner."""
    best, left = height.copy(), reach.copy()
    padded, ways = np.pad(height, 1, constant_values=-np.inf), np.pad(reach, 1, constant_values=-np.inf)
    n, m = height.shape
    for di in (0, 1, 2):
        for dj in (0, 1, 2):
            far = STEP[di != 1 and dj != 1]
            up, way = padded[di : di + n, dj : dj + m] - fall * far, ways[di : di + n, dj : dj + m] - cell * far
            better = (way > -1e-9) & (up > best)
            best[better], left[better] = up[better], way[better]
    return best, left
