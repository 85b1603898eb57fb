"""The points in contact and the rays to them, in one pass over a frame, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.perception.types import CONTACT, INVALID

__all__ = ["fill_touching"]


@kernel(
    [
        "void(float32[:,::1],uint8[::1],float32,float32[:,::1],float32[:,::1])",
        "void(float64[:,::1],uint8[::1],float64,float64[:,::1],float64[:,::1])",
    ]
)
def fill_touching(points: Any, labels: Any, camera: Any, touching: Any, rays: Any) -> None:
    """Fill the points (m, 3) in contact, of (n, 3) with labels (n,), and unit rays from a camera at (0, 0, z).

    Points that are invalid become NaN.
    """
    found = 0
    for i in range(labels.size):
        if labels[i] == CONTACT:
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            along = z - camera
            far = np.sqrt(x * x + y * y + along * along)
            touching[found, 0], touching[found, 1], touching[found, 2] = x, y, z
            rays[found, 0], rays[found, 1], rays[found, 2] = x / far, y / far, along / far
            found += 1
        elif labels[i] == INVALID:
            points[i, 0], points[i, 1], points[i, 2] = math.nan, math.nan, math.nan
