"""How far a membrane may stand off the object where it seems to touch: beyond an edge, over which it bends.

A membrane that resists bending passes over an edge in a bend some millimetres wide. Just beyond the edge it hangs free, but so close to
where it is held that it stays as the hand rises, and is bent as one that lies on something. No press from above
shows whether a wall or a flank is under it there. Up the slope the bend ends on the top, farther inside the edge the gentler it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.clouds.cloud import Cloud
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.support import LEAST, SMEARED, bends_along

__all__ = ["HANG_SD", "ends_of_bends", "stand_off", "with_stand_off"]

Array = npt.NDArray[np.float64]

#: m; standard deviation that all heights share: the camera's static error is measured wrongly, as the membrane hangs meanwhile
HANG_SD = 0.2e-3
#: m from an edge inwards to where the bend over it is half of its most, however sharp; rad, which over the bend adds to that; and the
#: standard deviation of both, m (`python benchmarks/cloud_errors.py`)
INSIDE, ANGLE, INSIDE_SD = 3.0e-3, 0.03, 0.6e-3
FARTHEST, STEP = 9.0, 0.5  # cells up the slope that the end of a bend is sought, and between looks
#: cells from the most of a bend to half of it, beyond which it follows a round surface: smoothed, one over a line has 2.4; by hand, on drawn bodies
ROUND = 5.5


def with_stand_off(cloud: Cloud, relief: Relief) -> Cloud:
    """Return a cloud of the world whose standard deviations hold the errors of the camera and of the membrane beside the noise."""
    return replace(cloud, apart=np.hypot(HANG_SD, stand_off(cloud.points, relief)))


def stand_off(points: Array, relief: Relief) -> Array:
    """Return the standard deviations (n,), m, of how far the membrane stands off the object at points (n, 3), m, world.

    It is the root mean square of how far a point lies outside an edge whose place is uncertain: within it the membrane lies on the top.

    Parameters
    ----------
    points : (n, 3) float, m, world
        Where it seemed to touch.
    relief : Relief
        The map with their presses in it.
    """
    from scipy.special import ndtr

    if not len(points):
        return np.zeros(0)
    end, bend = ends_of_bends(points, relief)
    over = end - INSIDE - ANGLE / np.maximum(bend, LEAST)
    # Farther out the membrane is not taken for contact: something else holds it up there.
    out = np.where(over < SMEARED * relief.cell + INSIDE_SD, over, -INSIDE) / INSIDE_SD
    density = np.exp(-(out**2) / 2) / np.sqrt(2 * np.pi)
    off = INSIDE_SD * np.sqrt(np.maximum((1 + out**2) * ndtr(out) + out * density, 0.0))
    return np.asarray(off.max(axis=0))


def ends_of_bends(points: Array, relief: Relief) -> tuple[Array, Array]:
    """Return how far from points (n, 3) the bend of the membrane falls to half of its most (2, n), m, and the most (2, n), 1/m.

    The first row goes up the slope, the second along the largest bend. The way is 0 where nothing is bent or the bend goes on, as
    over a dome.
    """
    steps = np.arange(0.0, FARTHEST + STEP / 2, STEP)
    both = [_end(bend, steps, relief.cell) for bend in _bends(points, relief, steps)]
    return np.stack([way for way, _ in both]), np.stack([most for _, most in both])


def _end(bend: Array, steps: Array, cell: float) -> tuple[Array, Array]:
    """Return the way (n,), m, and the most (n,), 1/m, of bends (k, n) at steps (k,), cells."""
    most = np.maximum.accumulate(bend, axis=0)
    low = bend < most / 2
    after, every = np.maximum(low.argmax(axis=0), 1), np.arange(bend.shape[1])
    top, before, behind = most[after, every], bend[after - 1, every], bend[after, every]
    way = steps[after - 1] + STEP * (before - top / 2) / np.maximum(before - behind, 1e-9)
    edge = low.any(axis=0) & (top > LEAST) & (way - steps[(bend == top).argmax(axis=0)] < ROUND)
    return np.where(edge, way * cell, 0.0), top


def _bends(points: Array, relief: Relief, steps: Array) -> Array:
    """Return the bends (2, k, n), 1/m, of the lowest membrane at steps (k,), cells, from points (n, 3): see `bends_along`."""
    from scipy.ndimage import find_objects

    seen = np.isfinite(relief.ceiling)
    part = find_objects(seen.astype(np.int64))[0]
    corner = np.array([p.start for p in part]) + relief.origin + 0.5
    heights = np.where(seen, relief.ceiling, np.nan)[part]
    return bends_along(heights, (points[:, :2] / relief.cell - corner).T, steps, cell=relief.cell)
