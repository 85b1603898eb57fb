"""How far the points of neighbouring pixels lie apart."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.smooth import derivative, slope
from stretch_bt.perception.surface import Cleaned, Surface

__all__ = ["Lateral", "lateral", "lateral_crossed"]

Image = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Lateral:
    """How far x moves from column to column and y from row to row, and how fast that changes on the way.

    `moves` (h, w, 4) is x_u, y_v, x_uu and y_vv per block of `every` x `every` pixels, m.
    """

    moves: Image
    every: int

    def of(self, surface: Surface) -> tuple[Image, int, int]:
        """Return the same for smaller blocks, as wide as the bins of a surface, and which of them is its first bin."""
        import cv2

        share = self.every // surface.step
        (v, u), (h, w) = surface.origin, surface.height.shape
        if share == 1:
            return self.moves, v, u
        # Bins between the middles of two blocks take from both.
        top, left = max(v // share - 1, 0), max(u // share - 1, 0)
        part = self.moves[top : (v + h) // share + 2, left : (u + w) // share + 2]
        finer = cv2.resize(part, None, fx=share, fy=share, interpolation=cv2.INTER_LINEAR)
        return np.asarray(finer), v - share * top, u - share * left


def lateral(cleaned: Cleaned, kernel: float) -> Lateral:
    """Return how far x and y move, averaged over a Gaussian of `kernel`, m; they change slowly."""
    return _moved(*_blocks(cleaned, kernel))


def lateral_crossed(cleaned: Cleaned, kernel: float) -> tuple[Lateral, Image, Image]:
    """Do as `lateral`, and return x_v / y_v and y_u / x_u of its blocks: a camera sees a slope move points aside, off its axis."""
    x, y, every, sigma, pitch = _blocks(cleaned, kernel)
    found = _moved(x, y, every, sigma, pitch)
    x_u, y_v = found.moves[..., 0], found.moves[..., 1]
    return found, derivative(x, sigma, 0, 1) / y_v, derivative(y, sigma, 1, 0) / x_u


def _moved(x: Image, y: Image, every: int, sigma: float, pitch: float) -> Lateral:
    """Return how far x and y move, of blocks as `_blocks` gives them."""
    import cv2

    least = np.float32(0.1 * pitch)
    x_u, y_v = (derivative(w, sigma, *along) + np.float32(pitch) for w, along in ((x, (1, 0)), (y, (0, 1))))
    if min(float(x_u.mean()), float(y_v.mean())) <= 0.0:
        raise InvalidInput(
            "points: x grows along the rows of the image and y along its columns, as in the camera's frame; these are mirrored"
        )
    x_u, y_v = np.maximum(x_u, least), np.maximum(y_v, least)
    return Lateral(np.asarray(cv2.merge([x_u, y_v, slope(x_u, 1), slope(y_v, 0)])), every)


def _blocks(cleaned: Cleaned, kernel: float) -> tuple[Image, Image, int, float, float]:
    """Return x and y less an even raster, m, in blocks, their width in pixels, the Gaussian's sigma in blocks, and their width, m."""
    from stretch_bt.perception.surface_kernel import fill_moves

    every = 2 ** max(0, math.floor(math.log2(max(kernel / cleaned.pitch, 1.0))))
    sigma, pitch = round(max(kernel / cleaned.pitch / every, 0.8), 1), cleaned.pitch * every
    x, y = np.empty((2, *(-(-n // every) for n in cleaned.valid.shape)), dtype=np.float32)
    fill_moves(cleaned.points, cleaned.valid, *cleaned.corner, every, pitch, x, y)
    return x, y, every, sigma, pitch
