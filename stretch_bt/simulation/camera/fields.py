"""Random images that are smooth over some pixels."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.camera.draws import normal

__all__ = ["SmoothField"]

Image = npt.NDArray[np.float32]
_NARROWEST = 0.1  # pixels
_REACH = 5.0  # kernels; beyond it a Gaussian adds nothing to single precision


class SmoothField:
    """Gaussian noise (h, w) of standard deviation 1 that is white noise smoothed by a Gaussian of `kernel` pixels.

    Its correlation at a distance d is exp(-d^2 / 4 kernel^2). Seeds a kernel apart are enough: by Poisson's sum the variance
    between them then differs by 2 exp(-pi^2) of itself, which is scaled away.
    """

    def __init__(self, shape: tuple[int, int], kernel: float) -> None:
        self.shape = shape
        self._down, self._across = (_spread(count, kernel) for count in shape)

    def seeds(self, random: np.random.Generator) -> Image:
        """Draw the numbers that an image grows from: they are few, and sums of them grow into sums of images."""
        return normal(random, (self._down.shape[1], self._across.shape[1]))

    def grow(self, seeds: Image) -> Image:
        """Return the image (h, w).

        The products are of double precision: differences in rounding between processors are lost in the image's single one.
        """
        image: Any = self._down @ (seeds.astype(np.float64) @ self._across.T)
        return np.asarray(image, np.float32)


@lru_cache(maxsize=32)
def _spread(count: int, kernel: float) -> npt.NDArray[np.float64]:
    """Return (count, seeds) float: how seeds along one axis spread over its pixels; each pixel's squares add up to 1."""
    if kernel <= 0:
        return np.eye(count)
    step = max(kernel, 1.0)  # a shorter one than a pixel has its seeds on the pixels
    margin = int(np.ceil(_REACH * kernel / step))
    seeds = step * np.arange(-margin, int(np.ceil(count / step)) + margin)
    width = max(kernel, _NARROWEST)  # whose square does not round to 0, and which reaches no other pixel either
    weights = np.exp(-((np.arange(count)[:, None] - seeds) ** 2) / (2 * width**2))
    weights[weights < 1e-7] = 0.0  # lost in the single precision of the image
    spread: npt.NDArray[np.float64] = weights / np.sqrt((weights**2).sum(axis=1, keepdims=True))
    spread.flags.writeable = False
    return spread
