"""How far the points of neighbouring pixels lie apart."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.smooth import derivative, slope
from stretch_bt.perception.surface import Cleaned, Surface

__all__ = ["Lateral", "lateral"]

Image = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Lateral:
    """How far x moves from column to column and y from row to row, and how fast that changes on the way.

    `moves` (h, w, 4) is x_u, y_v, x_uu and y_vv per block of `every` x `every` pixels, m.
    """

    moves: Image
    every: int

    def of(self, surface: Surface) -> Image:
        """Return the same (h, w, 4) per bin of a surface, whose bins are at most as large as the blocks."""
        import cv2

        share = self.every // surface.step
        (v, u), (h, w) = surface.origin, surface.height.shape
        # Bins between the middles of two blocks take from both.
        first = max(v // share - 1, 0), max(u // share - 1, 0)
        part = self.moves[first[0] : (v + h) // share + 2, first[1] : (u + w) // share + 2]
        finer = part if share == 1 else cv2.resize(part, None, fx=share, fy=share, interpolation=cv2.INTER_LINEAR)
        v, u = v - share * first[0], u - share * first[1]
        scale = np.array([1.0, 1.0, 1.0 / share, 1.0 / share], dtype=np.float32) / np.float32(share)
        return np.asarray(finer[v : v + h, u : u + w] * scale, dtype=np.float32)


def lateral(cleaned: Cleaned, kernel: float) -> Lateral:
    """Return how far x and y move, averaged over a Gaussian of `kernel`, m; they change slowly."""
    from stretch_bt.perception.surface_kernel import fill_moves

    every = 2 ** max(0, math.floor(math.log2(max(kernel / cleaned.pitch, 1.0))))
    sigma, pitch = round(max(kernel / cleaned.pitch / every, 0.8), 1), cleaned.pitch * every
    x, y = np.empty((2, *(-(-n // every) for n in cleaned.valid.shape)), dtype=np.float32)
    fill_moves(cleaned.points, cleaned.valid, *cleaned.corner, every, pitch, x, y)
    least = np.float32(0.1 * pitch)
    x_u = np.maximum(derivative(x, sigma, 1, 0) + np.float32(pitch), least)
    y_v = np.maximum(derivative(y, sigma, 0, 1) + np.float32(pitch), least)
    return Lateral(np.stack([x_u, y_v, slope(x_u, 1), slope(y_v, 0)], axis=-1), every)
