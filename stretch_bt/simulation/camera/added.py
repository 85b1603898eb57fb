"""Adding noise to the pixels that have a value."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.effects.base import Exposure

__all__ = ["add"]


def add(exposure: Exposure, noise: npt.NDArray[np.float32], sd: float, reference_depth: float | None) -> None:
    """Add noise (h, w) of standard deviation 1, scaled to `sd`, m: everywhere, or at a depth with whose square it grows."""
    from stretch_bt.simulation.camera.pixels_kernel import add as add_scaled

    even, growth = (sd, 0.0) if reference_depth is None else (0.0, sd / reference_depth**2)
    add_scaled(exposure.depth, noise, np.float32(even), np.float32(growth))
