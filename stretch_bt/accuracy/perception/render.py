"""The depth image of a deformed sheet."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates, spline_filter

from stretch_bt.frames import Intrinsics
from stretch_bt.simulation.membrane.sheet.result import Shape
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["render"]

_PITCH = 0.35e-3  # m of the unstretched sheet
_STEPS = 12
_MET = 1e-6  # lateral units; the step after it leaves nothing
_CLOSE = 0.02  # pixels; a ray that does not come so close to the sheet passes beside it or meets a fold


def render(shape: Shape, intrinsics: Intrinsics, plane_distance: float, pitch: float = _PITCH) -> tuple[Array, Array]:
    """Return what each pixel of a camera over the origin sees of the mid-surface of a sheet.

    Rays are followed by Newton's method on cubic splines through points of the surface every `pitch`, m, of the unstretched
    sheet, which are good to a few micrometres.

    Returns
    -------
    depth : (h, w) float, m
        Along the optical axis; 0 where the sheet is not seen.
    points : (h, w, 3) float, m, membrane frame
        NaN where the sheet is not seen.
    """
    columns, rows = (round((a.breaks[-1] - a.breaks[0]) * shape.unit / pitch) + 1 for a in (shape.mesh.x, shape.mesh.y))
    grid = shape.points(columns, rows)
    depth = plane_distance - grid[..., 2]
    across, along = grid[..., 0] / depth, grid[..., 1] / depth
    x = (np.arange(intrinsics.width) - intrinsics.cx) / intrinsics.fx
    y = (np.arange(intrinsics.height) - intrinsics.cy) / intrinsics.fy
    row, column, miss = _follow(across, along, *np.meshgrid(x, y))
    inside = (row >= 0) & (row <= rows - 1) & (column >= 0) & (column <= columns - 1)
    seen = inside & (miss * intrinsics.fx < _CLOSE)
    found = np.where(seen, _sample(spline_filter(depth), row, column), 0.0)
    points = np.where(seen, found, np.nan)[..., None] * np.stack([*np.meshgrid(x, y), np.ones_like(found)], axis=-1)
    points[..., 2] = plane_distance - points[..., 2]
    return found, points


def _follow(across: Array, along: Array, x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return row and column of the grid where it lies on each ray (x, y, 1), and by how much the ray is missed."""
    rows, columns = across.shape
    maps = [spline_filter(m) for m in (across, along)]
    slopes = [spline_filter(np.gradient(m, axis=axis)) for m in (across, along) for axis in (0, 1)]
    middle = rows // 2, columns // 2
    per_row, per_column = _spacing(along, across)
    row = np.clip(middle[0] + (y - along[middle]) / per_row, 0, rows - 1)
    column = np.clip(middle[1] + (x - across[middle]) / per_column, 0, columns - 1)
    miss = np.full(x.shape, np.inf)
    open_ = np.nonzero(np.ones(x.shape, dtype=bool))
    for _ in range(_STEPS):
        r, c = row[open_], column[open_]
        off_x, off_y = x[open_] - _sample(maps[0], r, c), y[open_] - _sample(maps[1], r, c)
        miss[open_] = np.hypot(off_x, off_y)
        xr, xc, yr, yc = (_sample(s, r, c) for s in slopes)
        area = xr * yc - xc * yr
        area = np.where(np.abs(area) > 1e-12, area, 1e-12)
        row[open_] = np.clip(r + np.clip((off_x * yc - off_y * xc) / area, -8, 8), -3, rows + 2)
        column[open_] = np.clip(c + np.clip((off_y * xr - off_x * yr) / area, -8, 8), -3, columns + 2)
        moving = miss[open_] > _MET
        open_ = open_[0][moving], open_[1][moving]
    return row, column, miss


def _spacing(along: Array, across: Array) -> tuple[float, float]:
    """Return the mean change of the rays from row to row and from column to column of the grid."""
    rows, columns = along.shape
    return (
        float(along[-1, columns // 2] - along[0, columns // 2]) / (rows - 1),
        float(across[rows // 2, -1] - across[rows // 2, 0]) / (columns - 1),
    )


def _sample(image: Array, row: Array, column: Array) -> Any:
    return map_coordinates(image, [row, column], order=3, mode="nearest", prefilter=False)
