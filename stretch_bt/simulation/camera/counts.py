"""From depth to what a camera sends."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.effects.base import Exposure

__all__ = ["counts"]

_MOST = 65535


def counts(exposure: Exposure) -> npt.NDArray[np.uint16]:
    """Return the (h, w) uint16 counts of an exposure: 0 where there is no value, or one that does not fit 16 bits."""
    raw = np.rint(exposure.depth * np.float32(1 / exposure.unit))
    raw[~((raw > 0) & (raw < _MOST))] = 0
    sent: npt.NDArray[np.uint16] = raw.astype(np.uint16)
    return sent
