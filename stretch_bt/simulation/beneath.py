"""Whether a body stands where the membrane can meet it, and which of several do: the others neither hold it up nor end its way down."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Pose
from stretch_bt.simulation.membrane.indenters.placed import Placed, place
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.indenters.turned import turn
from stretch_bt.simulation.objects.base import Standing
from stretch_bt.simulation.seat import seat

__all__ = ["beneath"]


def beneath(standing: Standing, pose: Pose, free: npt.NDArray[np.float64]) -> Standing | None:
    """Return the standing object, without those of several bodies that the free membrane (rows, columns, 3), m, does not meet.

    None where it meets none of them. A membrane that is held up by one body lies no lower anywhere, so it meets no other one for that.
    """
    body = standing.body
    if body is None:
        return standing
    where = seat(standing, pose)
    placed = place(turn(body, where.heading), where.at, where.tilt, where.depth)
    if not isinstance(body, Several):
        return standing if _is_met(placed[0], free) else None
    kept = [part for part, one in zip(body.parts, placed, strict=True) if _is_met(one, free)]
    if len(kept) in (0, len(body.parts)):
        return standing if kept else None
    below = min(part.below for part in kept)
    if len(kept) > 1:
        parts = tuple(part._replace(below=part.below - below) for part in kept)
        return replace(standing, body=Several(parts), top=standing.top - below)
    [part] = kept  # which stands on an axis of its own
    c, s = math.cos(standing.heading), math.sin(standing.heading)
    x, y = part.at[0], -part.at[1]
    return replace(
        standing,
        body=part.indenter,
        x=standing.x + c * x - s * y,
        y=standing.y + s * x + c * y,
        top=standing.top - below,
    )


def _is_met(body: Placed, free: npt.NDArray[np.float64]) -> bool:
    """Whether a body comes through the free membrane: by its top, or beside the membrane's border by its flank."""
    if body.top <= float(free[..., 2].min()):
        return False
    low, high = _inside(free)
    if bool(np.all((low < body.origin[:2]) & (body.origin[:2] < high))):
        return True
    return bool((body.gap(np.ascontiguousarray(free.reshape(-1, 3))).distance < 0.0).any())


def _inside(free: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the corners (x, y), m, of the largest rectangle that the membrane covers, which is narrower in its middle."""
    x, y = np.sort(free[..., 0], axis=1), np.sort(free[..., 1], axis=0)
    return np.array([x[:, 0].max(), y[0].max()]), np.array([x[:, -1].min(), y[-1].min()])
