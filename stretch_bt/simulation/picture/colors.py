"""Colours of pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["CONTACT", "FAINT", "INK", "INVALID", "MEMBRANE", "OBJECT", "SUPPORT", "WRONG", "shades", "to_rgb"]

INK, FAINT, WRONG = "#333333", "#9aa4ad", "#c0392b"
OBJECT, SUPPORT, MEMBRANE, CONTACT, INVALID = "#d8b787", "#b9bfc5", "#1f6fb2", "#e2492f", "#ff00ff"


def shades(values: npt.NDArray[Any], low: float, high: float) -> npt.NDArray[np.uint8]:
    """Return red, green and blue (..., 3) uint8 of values, from dark blue for `low` over green to yellow for `high`."""
    import cv2

    part = np.clip((values - low) / max(high - low, 1e-12), 0, 1)
    level = np.rint(255 * np.nan_to_num(part)).astype(np.uint8)
    colored: Any = cv2.applyColorMap(level.reshape(-1, 1), cv2.COLORMAP_VIRIDIS)
    return np.asarray(colored[:, 0, ::-1].reshape(*level.shape, 3), np.uint8)


def to_rgb(color: str) -> npt.NDArray[np.uint8]:
    """Return (3,) uint8."""
    return np.frombuffer(bytes.fromhex(color[1:]), np.uint8)
