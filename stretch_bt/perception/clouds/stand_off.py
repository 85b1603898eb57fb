"""How far a membrane may stand off the object where it seems to touch: beyond an edge, over which it bends.

A membrane that resists bending passes over an edge in a bend some millimetres wide. Just beyond the edge it hangs free, but so close to
where it is held that it stays as the hand rises, and is bent as one that lies on something. What is under it there, a wall or a flank, no
press from above tells. Up the slope the bend ends on the top, as far inside the edge as bend and smoothing are wide.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.support import bend_along
from stretch_bt.units import Estimate

__all__ = ["stand_off"]

Array = npt.NDArray[np.float64]

#: m from an edge inwards to where the bend over it is half of what it is at most (`python -m benchmarks.cloud_errors`)
INSIDE = Estimate(3.4e-3, 0.6e-3)
FARTHEST, STEP = 6.5, 0.5  # cells up the slope that the end of a bend is sought, and between looks
BENT = 20.0  # 1/m of a bend that is one: that of a membrane over a flat top is less


def stand_off(points: Array, relief: Relief) -> Array:
    """Return the standard deviations (n,), m, by which the membrane may stand off the object at points (n, 3), m, world; 0 where no edge is near.

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
    # Root mean square of how far a point lies outside an edge whose place is uncertain; within it the membrane lies on the top.
    out = (_end_of_bend(points, relief) - INSIDE.value) / INSIDE.sd
    density = np.exp(-(out**2) / 2) / np.sqrt(2 * np.pi)
    return np.asarray(INSIDE.sd * np.sqrt(np.maximum((1 + out**2) * ndtr(out) + out * density, 0.0)))


def _end_of_bend(points: Array, relief: Relief) -> Array:
    """Return how far up the slope from points (n, 3) the bend of the membrane falls to half, m, 0 where it is none or goes on."""
    steps = np.arange(0.0, FARTHEST + STEP, STEP)
    bend = _bends(points, relief, steps)
    most = np.maximum.accumulate(bend, axis=0)
    low = bend < most / 2
    end = low.argmax(axis=0)
    near, far = ((k, np.arange(len(points))) for k in (np.maximum(end - 1, 0), end))
    share = (bend[near] - most[far] / 2) / np.maximum(bend[near] - bend[far], 1e-9)
    found = low.any(axis=0) & (most[far] > BENT)
    return np.where(found, (steps[near[0]] + STEP * share) * relief.cell, 0.0)


def _bends(points: Array, relief: Relief, steps: Array) -> Array:
    """Return the bends (k, n), 1/m, along the slope at points (n, 3), of the lowest membrane steps (k,), cells, up that slope."""
    from scipy.ndimage import find_objects

    seen = np.isfinite(relief.ceiling)
    part = find_objects(seen.astype(np.int64))[0]
    corner = np.array([p.start for p in part]) + relief.origin + 0.5
    heights = np.where(seen, relief.ceiling, np.nan)[part]
    return bend_along(heights, (points[:, :2] / relief.cell - corner).T, steps, cell=relief.cell)
