"""The undeformed shape of a sensor, learned from its first frames, and the rise of later frames above it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_counts
from stretch_bt.errors import InvalidInput, NoContact, shown
from stretch_bt.frames import DepthFrame, as_numbers
from stretch_bt.perception.clean import median
from stretch_bt.perception.deprojection import depth_of
from stretch_bt.perception.regions import valid_box
from stretch_bt.perception.smooth import smooth
from stretch_bt.perception.types import FloatArray, MaskArray
from stretch_bt.plain_numbers import is_number

__all__ = ["Reference", "calmed", "check_kernel", "coarse_rise", "smoothed_rise"]

Image = npt.NDArray[np.float32]

Window = tuple[slice, slice]

SEEN = 0.5  # share of the reference frames in which a pixel must be valid
WIDEST = 1000  # pixels of a kernel; no camera of this kind has an image twice as wide
COVER = 0.75  # share of the pixels that a kernel usually sees, which it must see: fewer are the border of an area without depth
LEAST_COVER = 0.2  # share of the kernel that must see valid pixels in any case


def check_kernel(kernel: float) -> None:
    """Raise InvalidInput unless a kernel is a width in pixels that an image can have."""
    if not (is_number(kernel) and 0 < kernel <= WIDEST):
        raise InvalidInput(f"kernel is a number of pixels above 0 and up to {WIDEST}, got {shown(kernel)[:80]}")


class Reference:
    """Running mean of the first `count` frames, from any sensor whatever its shape at rest."""

    def __init__(self, count: int = 5) -> None:
        check_counts(1, reference=count)
        self.count = count
        self.learned = 0
        self._sum: npt.NDArray[np.float64] = np.zeros((0, 0))
        self._seen: npt.NDArray[np.int64] = np.zeros((0, 0), dtype=np.int64)
        self._mean: Image | None = None
        self._known: MaskArray = np.zeros((0, 0), dtype=bool)
        self._share: FloatArray = np.zeros((0, 0))  # of one frame in the mean of a pixel

    @property
    def complete(self) -> bool:
        """Whether all its frames have come."""
        return self.learned >= self.count

    @property
    def _enough(self) -> int:
        """In how many frames a pixel must be valid; one that was valid once alone differs from its mean by nothing, and shows no noise."""
        return max(math.ceil(SEEN * self.learned), min(self.learned, 2))

    def frames_in(self, known: MaskArray | None = None) -> float:
        """Return the number of frames in the mean of a pixel, as variances average over some known pixels (h, w) or all."""
        self._averaged()
        return 1.0 / float(np.mean(self._share[self._known if known is None else known]))

    def cover(self, kernel: float) -> float:
        """Return the share of a kernel whose pixels are known and valid in an ordinary frame, where the most are.

        Dropouts of a frame count as independent of those before it; an area without depth leaves other places whole.
        """
        if not self.learned:
            return 1.0
        known = self._seen >= self._enough
        valid = (self._seen / max(self.learned, 1)).astype(np.float32)
        whole = np.ones_like(valid)
        return math.prod(
            float(smooth(part, whole, kernel)[0].max(initial=0.0)) for part in (known.astype(np.float32), valid)
        )

    def learn(self, depth: FloatArray | DepthFrame) -> None:
        """Take a depth image (h, w), m, or a frame into the reference; one without a valid pixel does not count."""
        image, valid = self._image(depth)
        if not valid.any():
            return
        if not self.learned:
            self._sum = np.zeros(image.shape)
            self._seen = np.zeros(image.shape, dtype=np.int64)
        self._sum[valid] += image[valid]
        self._seen += valid
        self.learned += 1
        self._mean = None

    def _averaged(self) -> Image:
        """Return the mean of each pixel (h, w), m, once for all frames that come until the next one is learned."""
        if self._mean is None:
            self._mean = (self._sum / np.maximum(self._seen, 1)).astype(np.float32)
            self._known = self._seen >= self._enough
            self._share = 1.0 / np.maximum(self._seen, 1)
        return self._mean

    def _image(self, depth: FloatArray | DepthFrame, window: Window = np.s_[:, :]) -> tuple[FloatArray, MaskArray]:
        whole: npt.NDArray[Any] = (
            depth.raw if isinstance(depth, DepthFrame) else as_numbers("a depth image is", depth, "depth.filled(0)")
        )
        if self.learned and whole.shape != self._sum.shape:
            raise InvalidInput(f"the reference is of images of shape {self._sum.shape}, got {whole.shape}")
        if isinstance(depth, DepthFrame):
            return depth_of(depth.raw[window] * np.float32(depth.unit))
        return depth_of(whole[window] if whole.ndim == 2 else whole)

    @property
    def box(self) -> Window:
        """Rows and columns that hold all that the reference knows."""
        known = self._seen >= self._enough
        return valid_box(known) if known.any() else np.s_[:, :]

    def rise(self, depth: FloatArray | DepthFrame, window: Window = np.s_[:, :]) -> tuple[Image, MaskArray]:
        """Do as `difference`, with the median around each pixel, so that single flying ones vanish."""
        rise, known = self.difference(depth, window)
        return calmed(rise, known), known

    def difference(self, depth: FloatArray | DepthFrame, window: Window = np.s_[:, :]) -> tuple[Image, MaskArray]:
        """Return how far each pixel is nearer than the reference (h, w), m, 0 where unknown, and where both are valid.

        `window` is the rows and columns to return, by default all.

        Raises
        ------
        NoContact
            No pixel is valid in both.
        """
        image, valid = self._image(depth, window)
        if not self.learned:
            raise NoContact("no frame had depth so far; look whether the camera sees the membrane")
        mean = self._averaged()
        known = valid & self._known[window]
        if not known.any():
            raise NoContact(
                "no pixel has depth in this frame and in the reference, so that nothing can be compared; look whether the camera still"
                " sees the membrane"
            )
        return np.where(known, mean[window] - image, 0.0).astype(np.float32), known


def calmed(rise: Image, known: MaskArray) -> Image:
    """Return the median around each pixel (h, w), m, 0 where unknown."""
    return np.where(known, median(rise, known), np.float32(0))


def smoothed_rise(rise: Image, known: MaskArray, kernel: float, cover: float = 1.0) -> tuple[Image, MaskArray]:
    """Return the Gaussian mean of a rise over `kernel` pixels, and where enough pixels were seen to trust it.

    `cover` is the share of pixels that such a kernel usually sees.
    """
    return _trusted(rise, known.astype(np.float32), kernel, cover)


def coarse_rise(rise: Image, known: MaskArray, kernel: float, step: int, cover: float = 1.0) -> tuple[Image, MaskArray]:
    """Do as `smoothed_rise` in bins of `step` pixels, which costs less and says the same where the kernel is wider.

    Up to `step` - 1 rows and columns at the far edges are left out.
    """
    import cv2

    if step == 1 or min(rise.shape) < step:
        return smoothed_rise(rise, known, kernel, cover)
    rows, columns = (n // step for n in rise.shape)
    whole = np.s_[: rows * step, : columns * step]
    total, share = (
        np.asarray(cv2.resize(part[whole], (columns, rows), interpolation=cv2.INTER_AREA), dtype=np.float32)
        for part in (rise, known.astype(np.float32))
    )
    mean = np.divide(total, share, out=np.zeros_like(total), where=share > 0)
    # A bin spreads a pixel by (step^2 - 1) / 12 already.
    return _trusted(mean, share, math.sqrt(kernel**2 - (step**2 - 1) / 12.0) / step, cover)


def _trusted(rise: Image, weight: Image, kernel: float, usual: float) -> tuple[Image, MaskArray]:
    mean, cover = smooth(rise, weight, kernel)
    trusted = cover > max(COVER * usual, LEAST_COVER)
    if not trusted.any():
        raise NoContact(
            "too few neighbouring pixels have depth in the frame and its reference to average their noise; look whether something hides"
            " the membrane, or dazzles the camera"
        )
    return mean, trusted
