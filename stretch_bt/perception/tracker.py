"""Height of a press on any soft sensor, frame by frame."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.average import check_one_hand
from stretch_bt.perception.clean import far_pixels, flying_pixels, median, without_holes
from stretch_bt.perception.deprojection import depth_of
from stretch_bt.perception.height import top_of_pixels
from stretch_bt.perception.noise_of_frame import noise_spectrum
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.reference import Reference, calmed, check_kernel, smoothed_rise
from stretch_bt.perception.robust import MAD_TO_SD, sparse
from stretch_bt.perception.steps import shared_step, step_of
from stretch_bt.perception.stripes import Stripes
from stretch_bt.perception.surface import Cleaned
from stretch_bt.perception.types import FloatArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["HeightTracker"]

Image = npt.NDArray[np.float32]

CLEAR = 6.0  # standard deviations above which the highest place is the press and not noise
TOP = 0.85  # share of the smoothed height that its surroundings keep within the top
# factor on the difference from the height by half the disc: over a tip the error of a quadratic goes with the width of the disc, and half of it
# is left; under a contact that is known no tip is so blunt
BY_HALF = 2.0
SQRT_HALF_PI = math.sqrt(math.pi / 2.0)  # a Gaussian's standard deviation over its mean absolute value


class HeightTracker:
    """Tracks how far the highest point of a press stands above the sensor at rest, causally.

    The shape at rest is the mean of the first `reference` frames, so it need not be flat; heights before it is complete
    count from the frames so far. `kernel`, pixels, is the Gaussian that finds the place of the press; the height
    itself is measured on the unsmoothed image around that place. A light press by a small body, that touches less than half a kernel
    across, is a cusp that noise rounds off: its height is too low, by more than is stated. A narrower kernel reads it better.
    A camera whose distance drifts as it warms up shows its drift as a press, or as less than none.
    """

    def __init__(self, *, reference: int = 5, kernel: float = 10.0) -> None:
        check_kernel(kernel)
        self._reference = Reference(reference)
        self._first: DepthFrame | None = None
        self._kernel = kernel
        self._cover = 1.0  # share of a kernel that has depth in an ordinary frame
        self._white = 0.0  # of one image, which does not show the noise that its pixels share; until frames differ
        self._noise: list[float] = []
        self._spectrum: NoiseSpectrum | None = None
        self._quiet = 0.0
        self._place: tuple[int, int] | None = None
        self._step = 0.0

    def update(self, depth: FloatArray | DepthFrame) -> Estimate:
        """Take the next depth image (h, w), m, or frame, and return the height of the press, m, with its sd.

        Raises
        ------
        NoContact
            The frame has no valid pixel in common with the reference.
        InvalidInput
            The frame is of another camera, stretch or distance of the plane than the first one.
        """
        if isinstance(depth, DepthFrame):
            self._first = self._first or depth
            check_one_hand("height tracker", depth, self._first)
        learning = not self._reference.complete
        if learning:
            self._reference.learn(depth)
            self._cover = self._reference.cover(self._kernel)
        raw, known = self._reference.difference(depth)
        rise = calmed(raw, known)
        mean, trusted = smoothed_rise(rise, known, self._kernel, self._cover)
        frames = self._reference.frames_in(known)
        highest = np.unravel_index(int(np.argmax(np.where(trusted, mean, -np.inf))), mean.shape)
        v, u = int(highest[0]), int(highest[1])
        if learning:
            self._learn_noise(depth, mean, known & trusted)
            self._quiet = max(self._quiet, float(mean[v, u]))
            self._step = self._step or _step(depth)
            if self._reference.complete and self._reference.learned > 1:
                self._spectrum = _spectrum(raw, known, frames, self._reference.frames_in())
        elif not self._noise:  # a reference of one frame
            self._noise.append(_noise_of(mean[known & trusted]) / math.sqrt(2.0))
        # a rise holds the noise of this frame and of the mean
        sd = float(np.median(self._noise or [self._white])) * math.sqrt(1.0 + 1.0 / frames)
        clear = float(mean[v, u]) > max(CLEAR * sd, 2.0 * self._quiet)
        # The highest of many noisy places is biased; until one stands out, the last frame's place is read.
        at = (v, u) if clear or self._place is None else _nearest(trusted, self._place)
        self._place = (v, u)
        if not clear:
            found = Estimate(float(mean[at]), math.hypot(sd, self._hidden(float(mean[v, u]), float(mean[at]))))
        elif self._spectrum is None:
            found = self._top(rise, known, mean, at, sd)
        else:  # no median has smoothed the heights, or taken pixels out of it that lie anywhere
            found = self._top(raw, known & ~far_pixels(raw, rise, known, 0.0), mean, at, sd)
        pixel = 2.0 * math.sqrt(math.pi) * self._kernel * sd
        return Estimate(found.value, math.hypot(found.sd, shared_step(self._step, pixel)))

    def _hidden(self, highest: float, read: float) -> float:
        """Return the error of a height, m, as the highest place may be a press that does not stand out yet.

        It surely is one at half as much again as quiet frames reach, and none up to what they do.
        """
        share = min(max(highest / self._quiet - 1.0, 0.0) / 0.5, 1.0) if self._quiet > 0.0 else 0.0
        return share * max(highest - read, 0.0)

    def _learn_noise(self, depth: FloatArray | DepthFrame, mean: Image, seen: MaskArray) -> None:
        """Note the noise of a smoothed value: as white noise from the first frame, then as the frames differ."""
        if self._reference.learned == 1:
            image = depth_of(depth)[0].astype(np.float32)
            fine = np.sort(np.abs(sparse((image - median(image, seen))[seen])))
            pixel = SQRT_HALF_PI * float(fine[: max(1, int(0.98 * fine.size))].mean())
            self._white = pixel / (2.0 * math.sqrt(math.pi) * self._kernel)
        else:
            n = self._reference.frames_in(seen)
            # A frame among n that form the mean differs from it by sqrt((n - 1) / n) of its own noise.
            self._noise.append(_noise_of(mean[seen]) * math.sqrt(n / (n - 1)))

    def _top(self, rise: Image, known: MaskArray, mean: Image, at: tuple[int, int], sd: float) -> Estimate:
        """Return the height of the top around a place, or the mean there where no top can be fitted."""
        reach = int(np.ceil(2.0 * self._kernel))
        v0, u0 = max(at[0] - reach, 0), max(at[1] - reach, 0)
        window = np.s_[v0 : at[0] + reach + 1, u0 : at[1] + reach + 1]
        v, u = np.nonzero(known[window] & (mean[window] > TOP * mean[at]))
        # Lateral pixels count as metres here: a height does not depend on the lateral unit.
        cloud = np.column_stack([u, v, rise[window][v, u]]).astype(np.float64)
        wide = rise.shape[1]
        try:
            top = top_of_pixels(cloud, (v + v0) * wide + u + u0, wide, self._spectrum, BY_HALF)
        except NoAnswer:
            return Estimate(float(mean[at]), sd)
        # Noise chose the place, and raises it.
        return Estimate(top.value, float(np.hypot(top.sd, sd)))


def _nearest(trusted: MaskArray, place: tuple[int, int]) -> tuple[int, int]:
    """Return the trusted place (h, w) that is nearest to a place, itself where it is trusted."""
    if trusted[place]:
        return place
    v, u = np.nonzero(trusted)
    nearest = int(np.argmin((v - place[0]) ** 2 + (u - place[1]) ** 2))
    return int(v[nearest]), int(u[nearest])


def _noise_of(values: Image) -> float:
    """Return the standard deviation of values (n,) around 0, most of which are noise."""
    return MAD_TO_SD * float(np.median(sparse(np.abs(values))))


def _spectrum(rise: Image, known: MaskArray, frames: float, later: float) -> NoiseSpectrum:
    """Return the noise of later rises, from the rise (h, w), m, of a frame that is one of the reference's own.

    Nothing is touched in it. The mean is of `frames` frames in its pixels, and of `later` in the pixels of later rises.
    """
    import cv2

    # The spectrum looks at whole neighbourhoods, of which dropouts here and there would leave none.
    whole, near = without_holes(rise, known), cv2.dilate(known.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    flat = Cleaned(
        whole, near, near & ~flying_pixels(whole, near, 0.0), np.empty((0, 0, 3)), np.s_[:, :], rise.shape, 1.0, 0.0, 1
    )
    noise = noise_spectrum(flat)
    # The mean holds a share of the last frame's noise, and none of a later one's.
    more = (1.0 + 1.0 / later) / (1.0 - 1.0 / frames)
    lines = Stripes(more * noise.stripes.rows, more * noise.stripes.columns)
    return NoiseSpectrum(more * noise.variances, noise.lengths, lines)


def _step(depth: FloatArray | DepthFrame) -> float:
    """Return the step in which depth comes, m: the unit of a frame, or the step that an image shows."""
    if isinstance(depth, DepthFrame):
        return depth.unit
    image, valid = depth_of(depth)
    seen = image[valid]
    try:
        return step_of(seen, seen)
    except IllConditioned:
        return float(np.spacing(seen.max(initial=1e-3)))
