"""Heights that a membrane is expected to have over a surface: a taut sheet hung over it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["drape"]

Array = npt.NDArray[np.float64]

TENSIONS = 3.0  # tension towards the clamps over the one across, of the sheet solver at stretch 0
OVER = 1.8  # relaxation
ROUNDS = 40


def drape(ground: Array, level: Array) -> Array:
    """Return the heights of sheets clamped at two ends over grounds, m.

    Off contact a membrane in tension obeys T_i z_xx + T_j z_yy = 0; on contact it lies on the ground. The sides are free. It is
    solved by projected over-relaxation, all sheets at once.

    Parameters
    ----------
    ground : (k, n, m) float, m
        Heights under each sheet; axis 1 across, axis 2 from clamp to clamp, whose ends are the clamps. Square cells.
    level : (k,) float, m
        Height of the clamps.
    """
    k, n, m = ground.shape
    sheet = np.maximum(np.broadcast_to(level[:, None, None], (k, n, m)), ground)
    sheet[:, :, 0] = sheet[:, :, -1] = level[:, None]
    near = np.pad(sheet, ((0, 0), (1, 1), (0, 0)), mode="edge")
    sheet = near[:, 1:-1]
    for turn in range(2 * ROUNDS):
        near[:, 0], near[:, -1] = sheet[:, 0], sheet[:, -1]
        for row in (0, 1):  # every other cell, as on a chessboard: none of them is a neighbour of another
            left = (turn + row) % 2
            inner, rows = sheet[:, row::2, left + 1 : -1 : 2], sheet[:, row::2]
            across = near[:, row:-2:2, left + 1 : -1 : 2] + near[:, row + 2 :: 2, left + 1 : -1 : 2]
            along = rows[:, :, left:-2:2] + rows[:, :, left + 2 :: 2]
            wanted = (across + TENSIONS * along) / (2 + 2 * TENSIONS)
            np.maximum(inner + OVER * (wanted - inner), ground[:, row::2, left + 1 : -1 : 2], out=inner)
    return np.ascontiguousarray(sheet)
