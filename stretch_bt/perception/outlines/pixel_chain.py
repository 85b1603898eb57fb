"""The chain of pixels that a border tracer gives for a closed curve."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.outlines.polyline import MOST, Curve, perimeter_of, spacing_of

__all__ = ["chain_of"]


def chain_of(curve: Curve) -> Curve:
    """Return the chain of pixels that a border tracer gives for the inside of a curve, in steps of its grid.

    A curve that goes from pixel to pixel already is its own chain; any other is drawn on a grid of its spacing.
    """
    import cv2

    steps = np.roll(curve, -1) - curve
    size = np.abs(np.concatenate([steps.real, steps.imag]))
    step = float(size.max())
    if (np.minimum(size, np.abs(size - step)) < 1e-6 * step).all():
        return curve
    gap = max(spacing_of(curve), perimeter_of(curve) / MOST)
    drawn = _filled((curve - complex(curve.real.min(), curve.imag.min())) / gap + (2 + 2j))
    found, _ = cv2.findContours(drawn, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return curve
    pixels = max(found, key=len)[:, 0].astype(np.float64)
    return np.asarray(pixels[:, 0] + 1j * pixels[:, 1]) if len(pixels) > 2 else curve


def _filled(curve: Curve) -> npt.NDArray[np.uint8]:
    """Return the image whose pixels are 1 where their middle lies inside: the sides to the left of it are odd in number."""
    rows, columns = int(curve.imag.max()) + 3, int(curve.real.max()) + 3
    crossed = np.zeros((rows, columns), dtype=np.int64)
    ends = np.roll(curve, -1)
    lower, upper = np.where(curve.imag <= ends.imag, curve, ends), np.where(curve.imag <= ends.imag, ends, curve)
    first, last = np.ceil(lower.imag).astype(np.int64), np.ceil(upper.imag).astype(np.int64)
    side = np.repeat(np.arange(len(curve)), last - first)
    row = np.arange(len(side)) - np.repeat(np.cumsum(last - first) - (last - first), last - first) + first[side]
    rise = upper.imag[side] - lower.imag[side]
    x = lower.real[side] + (upper.real[side] - lower.real[side]) * (row - lower.imag[side]) / rise
    np.add.at(crossed, (row, np.ceil(x).astype(np.int64)), 1)
    return (np.cumsum(crossed, axis=1) % 2).astype(np.uint8)
