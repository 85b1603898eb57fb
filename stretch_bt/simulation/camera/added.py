"""Adding noise to the pixels that have a value."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.effects.base import Exposure

__all__ = ["LEAST", "add"]

#: m; noise takes no pixel behind the camera, where depth would mean that there is no value
LEAST = np.float32(1e-6)


def add(exposure: Exposure, noise: npt.NDArray[np.float32], sd: float, reference_depth: float | None) -> None:
    """Add noise (h, w) of standard deviation 1, scaled in place to `sd`, m, at a depth it grows from, or at all depths."""
    depth = exposure.depth
    seen = depth > 0
    if reference_depth is None:
        noise *= np.float32(sd)
    else:
        noise *= np.square(depth) * np.float32(sd / reference_depth**2)
    noise += depth
    np.maximum(noise, LEAST, out=noise)
    exposure.depth = np.multiply(noise, seen, out=noise)
