"""Unit normals by Gaussian derivatives."""

from __future__ import annotations

import numpy as np

from stretch_bt.perception.curvature import bending
from stretch_bt.perception.lateral import Lateral, lateral_crossed
from stretch_bt.perception.smooth import enlarge
from stretch_bt.perception.surface import Surface, binned_surface, check_points, clean
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["estimate_normals", "surface_normals"]


def estimate_normals(points: FloatArray, valid: MaskArray, *, kernel: float = 1.9e-3) -> tuple[FloatArray, MaskArray]:
    """Return unit normals that face the camera, in the frame of the points, and where they can be trusted.

    Parameters
    ----------
    points : (h, w, 3) float, m
        Camera or membrane frame; distinguished by the distance relative to the width.
    valid : (h, w) bool
    kernel : float, m
        Standard deviation of the Gaussian; more averages more noise and rounds edges more.

    Returns
    -------
    normals : (h, w, 3) float32, NaN where not trusted
    trusted : (h, w) bool
        Valid, with most of the kernel on valid pixels.
    """
    check_points(points, valid)
    found = np.full(points.shape, np.nan, dtype=np.float32)
    trusted = np.zeros(valid.shape, dtype=bool)
    cleaned = clean(points, valid)
    if cleaned is None:
        return found, trusted
    surface = binned_surface(cleaned, kernel)
    shape = cleaned.valid.shape
    seen = cleaned.valid & (enlarge(surface.trusted.astype(np.float32), surface.step, shape) > 0.5)
    trusted[cleaned.box] = seen
    near = surface_normals(surface, *lateral_crossed(cleaned, kernel), shape)
    near[~seen] = np.nan
    found[cleaned.box] = near
    return found, trusted


def surface_normals(
    surface: Surface, moves: Lateral, x_aside: FloatArray, y_aside: FloatArray, shape: tuple[int, int]
) -> FloatArray:
    """Return unit normals (h, w, 3) of the pixels of a surface: (-h_x, -h_y, 1) normalised, turned to its frame."""
    bent = bending(surface, moves)
    along_u, along_v = (enlarge(image, surface.step, shape) for image in (bent.x, bent.y))
    x_v, y_u = (enlarge(image, moves.every, shape) for image in (x_aside, y_aside))
    # h_u = h_x x_u + h_y y_u, and h_v likewise
    left = np.maximum(1.0 - x_v * y_u, 0.1)
    h_x, h_y = (along_u - y_u * along_v) / left, (along_v - x_v * along_u) / left
    found = np.empty((*shape, 3), dtype=np.float32)
    found[..., 2] = 1.0 / np.sqrt(1.0 + h_x * h_x + h_y * h_y)
    found[..., 0] = -h_x * found[..., 2]
    found[..., 1] = -h_y * found[..., 2]
    found[..., 2] *= surface.towards
    return found
