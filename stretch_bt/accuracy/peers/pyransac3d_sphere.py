"""pyRANSAC-3D's sphere: the best of many spheres through four points each."""

from __future__ import annotations

import random
from typing import Any

__all__ = ["NAME", "PACKAGES", "SETTING", "curvature"]

NAME, PACKAGES = "pyRANSAC-3D", ("pyransac3d",)
_TRIES = 1000  # as it comes
_WIDTH = 2.0  # standard deviations of noise within which a point counts
SETTING = f"{_TRIES} tries"


def curvature(points: Any, noise: float) -> float:
    """Return 1/R, 1/m, of points (n, 3), m, with a standard deviation, m."""
    import numpy as np
    import pyransac3d

    random.seed(0)
    with np.errstate(all="ignore"):  # four points in a plane
        found = pyransac3d.Sphere().fit(np.asarray(points, dtype=float), thresh=_WIDTH * noise, maxIteration=_TRIES)
    return float(1.0 / found.radius)
