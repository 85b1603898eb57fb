"""The part of a contact that stands clearly above the top found in it: then skirt was taken for contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.smooth import least_seen, medians
from stretch_bt.perception.top import Places
from stretch_bt.perception.types import FloatArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["HighMeans", "HighPart", "clearly_above", "means_of", "sd_of_mean"]

WIDE = 9  # pixels along a side, of the means that are compared
MEDIAN = 5  # pixels along a side, of the median that takes away single wild ones
LEAST_ABOVE, BEYOND = (
    3.0,
    1.5,
)  # standard deviations, at least, and added to how far the highest of as many means stands above them all
FALL = 0.15  # share of its height that a top falls within the part that shows it
LEAST = 60  # pixels of such a part
PATCHES = 2.0  # independent values that it must hold to show a top
BENT = 0.03  # share of its height that a top falls within such a mean, or less


@dataclass(frozen=True, slots=True)
class HighPart:
    """Pixels (n,) that hang together about the highest mean of a contact; `height`, m, is that mean.

    `is_enough` says whether they are as many as show a top.
    """

    places: Places
    height: Estimate
    is_enough: bool


@dataclass(frozen=True, slots=True)
class HighMeans:
    """Means (h, w), m, of squares about each of `count` pixels in contact, -infinity elsewhere.

    `corner` is the row and column of the first in an image `wide` pixels wide.
    """

    mean: FloatArray
    count: int
    corner: tuple[int, int]
    wide: int

    @classmethod
    def of(cls, points: FloatArray, valid: MaskArray, touching: MaskArray) -> Self:
        """Take the means of all pixels in contact (h, w)."""
        box = _box(touching)
        touching = touching[box]
        seen = valid[box] & np.isfinite(points[box][..., 2])
        mean = means_of(points[box][..., 2], seen)
        mean[~touching] = -np.inf
        return cls(mean, int(np.count_nonzero(touching)), (box[0].start, box[1].start), valid.shape[1])

    def above(self, noise: NoiseSpectrum, top: Estimate) -> HighPart | None:
        """Return the high part, or None where the highest mean is not clearly above `top`, m.

        A membrane that touches nothing has no summit: where it stands higher, there is the top.
        """
        import cv2

        off = sd_of_mean(noise)
        highest = float(self.mean.max())
        above = clearly_above(self.count, noise)
        if not highest > top.value + above * math.hypot(top.sd, off):
            return None
        _, parts = cv2.connectedComponents((self.mean > highest - max(above * off, FALL * abs(highest))).view(np.uint8))
        rows, columns = np.nonzero(np.asarray(parts) == int(np.asarray(parts).flat[int(self.mean.argmax())]))
        if rows.size < LEAST:
            return None
        found: npt.NDArray[np.intp] = (rows + self.corner[0]) * self.wide + columns + self.corner[1]
        enough = rows.size >= PATCHES * noise.area
        return HighPart(found, Estimate(highest, math.hypot(off, BENT * highest)), enough)


def means_of(z: FloatArray, seen: MaskArray, least: float = 0.9) -> npt.NDArray[np.float32]:
    """Return the means (h, w), m, of squares about each pixel, but for single wild ones; -infinity where less is seen than `least_seen` has."""
    import cv2

    share = cv2.blur(seen.astype(np.float32), (WIDE, WIDE))
    middle = np.where(seen, medians(np.where(seen, z, 0.0).astype(np.float32), seen, MEDIAN), np.float32(0))
    least = least_seen(share, least)
    mean = np.asarray(cv2.blur(middle, (WIDE, WIDE)) / np.maximum(share, 0.5 * least), dtype=np.float32)
    mean[share < least] = -np.inf
    return mean


def sd_of_mean(noise: NoiseSpectrum) -> float:
    """Return the standard deviation, m, of such a mean of which all is seen."""
    return math.sqrt(noise.of_mean(WIDE**2) + noise.white_sd**2 / WIDE**2)


def clearly_above(pixels: int, noise: NoiseSpectrum) -> float:
    """Return by how many standard deviations the highest of the means of so many pixels stands above what is as high as all of them."""
    return max(LEAST_ABOVE, BEYOND + math.sqrt(2.0 * math.log(1.0 + pixels / max(noise.area, WIDE**2))))


def _box(touching: MaskArray) -> tuple[slice, slice]:
    """Return the box of an image that holds all of a mask (h, w), with a margin."""
    v, u = (
        slice(max(int(np.argmax(line)) - WIDE, 0), line.size - max(int(np.argmax(line[::-1])) - WIDE, 0))
        for line in (np.asarray(touching.any(axis=1)), np.asarray(touching.any(axis=0)))
    )
    return v, u
