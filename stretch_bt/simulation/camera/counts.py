"""The last step of an exposure: whole counts of 16 bits."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.effects.base import Exposure

__all__ = ["counts"]

_MOST = 65535


def counts(exposure: Exposure) -> npt.NDArray[np.uint16]:
    """Return (h, w) uint16 counts of `exposure.unit`, m; 0 where there is no value, or one that 16 bits do not hold."""
    scaled = exposure.depth * np.float32(1 / exposure.unit)
    np.rint(scaled, out=scaled)
    np.copyto(scaled, 0, where=~((scaled > 0) & (scaled < _MOST)))
    return scaled.astype(np.uint16)
