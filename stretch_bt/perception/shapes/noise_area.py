"""The noise of one frame, and over how many pixels it is alike, from the residual to a smooth surface."""

from __future__ import annotations

import numpy as np

from stretch_bt.perception.correlation import area_of
from stretch_bt.perception.surface import check_points, surface_of
from stretch_bt.perception.types import FloatArray, SurfaceNoise

__all__ = ["surface_noise"]

KERNEL = 1.9e-3  # m; leaves little of the membrane in the residual


def surface_noise(surface: FloatArray) -> SurfaceNoise | None:
    """Return the noise of a surface (h, w, 3), m, NaN where invalid, as `find_contact` hands it on with a contact.

    None where no two valid pixels are neighbours.
    """
    check_points(surface)
    seen = np.asarray(np.isfinite(surface).all(axis=2))
    found = surface_of(surface, seen, KERNEL)
    return None if found is None else SurfaceNoise(found.noise, area_of(found.length))
