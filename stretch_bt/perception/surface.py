"""A depth image made ready for differentiation: cropped, cleaned, binned to the scale of the kernel, holes filled."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_unmasked
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.perception.clean import flying_pixels
from stretch_bt.perception.correlation import left_of_one, noise_of, spread_of_mean
from stretch_bt.perception.pitch import check_pitch, check_square, pitch_of
from stretch_bt.perception.regions import valid_box
from stretch_bt.perception.robust import MAD_TO_SD, quantile, sample
from stretch_bt.perception.smooth import covered, derivative, shrink
from stretch_bt.perception.stripes import NO_STRIPES, Stripes, stripes_of, without_lines
from stretch_bt.perception.types import FloatArray, LabelArray, MaskArray
from stretch_bt.plain_numbers import is_number

__all__ = [
    "Cleaned",
    "Surface",
    "binned_surface",
    "camera_side",
    "check_array",
    "check_labels",
    "check_points",
    "clean",
    "finite",
    "surface_of",
]

Image = npt.NDArray[np.float32]
Box = tuple[slice, slice]

LARGEST_KERNEL = 0.05  # m
CAMERA_RATIO = 0.4  # distance over width: a camera frame is above it up to a field of view of 100 degrees
COVER = 0.5  # share of the kernel that must see valid pixels
ONE_SIDED = 0.08  # how fast that share may change over a kernel's width: 1.8 widths away from a straight edge
LEAST_SIGMA = 2.0  # bins a kernel keeps: binning that far loses a fortieth of the peak of a second derivative
MOST_SIGMA = 6.0
SHARED = 0.4  # bins; noise shared over less is white as far as bins can show


@dataclass(frozen=True, slots=True)
class Cleaned:
    """The part of an image that holds its valid pixels, without flying pixels.

    `height` (h, w) float32 is z towards the camera, m, above `level`, 0 in holes; `valid` the pixels that are left, `seen` those before
    that are finite. `box` places them in the whole image of shape `shape`, of which `points` are the rows of x, y, z, m, one after another.
    `pitch` is the distance of neighbours, m, and `towards` is +1 where z points to the camera (membrane frame), -1 where
    away (camera frame).
    """

    height: Image
    seen: MaskArray
    valid: MaskArray
    points: FloatArray
    box: Box
    shape: tuple[int, int]
    pitch: float
    level: float
    towards: int
    _bins: dict[int, tuple[Image, Image]] = field(default_factory=dict, repr=False, compare=False)
    _stripes: list[Stripes] = field(default_factory=list, repr=False, compare=False)

    @property
    def corner(self) -> tuple[int, int]:
        """Row and column of the first pixel in the whole image."""
        return self.box[0].start, self.box[1].start

    @property
    def stripes(self) -> Stripes:
        """Noise that whole rows and columns share."""
        if not self._stripes:
            self._stripes.append(stripes_of(self.height, self.valid))
        return self._stripes[0]

    def bins(self, step: int) -> tuple[Image, Image]:
        """Return the mean height of the valid pixels in bins of `step`, a power of 2, and the share that is valid."""
        if step == 1:
            return np.where(self.valid, self.height, np.float32(0)), self.valid.astype(np.float32)
        if step not in self._bins:
            finer = (self.height, self.valid) if step == 2 else self.bins(step // 2)
            self._bins[step] = shrink(*finer)
        return self._bins[step]


@dataclass(frozen=True, slots=True)
class Surface:
    """Height towards the camera, m, above `level`, in bins of `step` x `step` pixels, its holes filled.

    `trusted` marks bins with valid ones on all sides, so that derivatives of `sigma` bins mean something; `pitch` is the
    width of a bin, m. `noise` is the standard deviation of one pixel, m, and `length` says how far pixels share it:
    it is like white noise smoothed by a Gaussian of `length` pixels. `view` is the width of all that is seen, m.
    `origin` is the row and column of its first bin where it is part of a larger one. Rows and columns of pixels share `stripes` besides.
    """

    height: Image
    smooth: Image
    valid: MaskArray
    trusted: MaskArray
    level: float
    pitch: float
    sigma: float
    step: int
    noise: float
    length: float
    towards: int
    view: float
    origin: tuple[int, int] = (0, 0)
    stripes: Stripes = NO_STRIPES

    def part(self, window: Box) -> Surface:
        """Return the bins of a window (rows, columns)."""
        height, mean, valid = self.height[window], self.smooth[window], self.valid[window]
        first = (self.origin[0] + window[0].start, self.origin[1] + window[1].start)
        return replace(self, height=height, smooth=mean, valid=valid, trusted=self.trusted[window], origin=first)

    @property
    def smooth_sd(self) -> float:
        """Standard deviation of the smoothed height, m."""
        return self.noise_after((0, 0, 1.0))

    def noise_after(self, *orders: tuple[int, int, float]) -> float:
        """Return the standard deviation, m, of a sum of derivatives (along u, along v, weight) per bin."""
        pixels = round(20.0 * math.hypot(self.step * self.sigma, self.step / math.sqrt(12.0))) / 20.0
        each = [(a, b, weight * self.step ** (a + b)) for a, b, weight in orders]
        local = self.noise * spread_of_mean(self.length, pixels, *each)
        if self.stripes == NO_STRIPES:
            return local
        return math.sqrt(local**2 + self.stripes.after(pixels, *each))


def check_array(what: str, given: object) -> None:
    """Raise InvalidInput unless something is an array of numpy without a mask of its own, which nothing here would heed."""
    if not isinstance(given, np.ndarray):
        raise InvalidInput(f"{what} is an array of numpy, got {type(given).__name__}; give numpy.asarray({what})")
    check_unmasked(f"{what} is", given, f"{what}.filled(numpy.nan)")


def check_points(points: FloatArray, *masks: MaskArray) -> None:
    """Raise InvalidInput unless points are (h, w, 3) floats and the mask of the valid ones, where one is given, is (h, w) bool."""
    for what, given in (("points", points), *(("valid", mask) for mask in masks)):
        check_array(what, given)
    if points.ndim != 3 or points.shape[2] != 3 or points.dtype.kind != "f":
        raise InvalidInput(f"points are (h, w, 3) floats in m, got {points.dtype} {points.shape}")
    for valid in masks:
        if valid.shape != points.shape[:2] or valid.dtype != np.bool_:
            raise InvalidInput(f"valid is a bool mask of shape {points.shape[:2]}, got {valid.dtype} {valid.shape}")


def check_labels(labels: LabelArray, points: FloatArray) -> None:
    """Raise InvalidInput unless labels belong to an image of such points (h, w, 3)."""
    if not isinstance(labels, np.ndarray) or labels.dtype != np.uint8:
        kind = getattr(labels, "dtype", type(labels).__name__)
        raise InvalidInput(f"labels are a (h, w) uint8 image of 0, 1, 2 and 255, got {kind}")
    check_unmasked("labels are", labels, "labels.filled(255)")
    if labels.shape != points.shape[:2]:
        raise InvalidInput(f"labels need the shape of the frame, {points.shape[:2]}, got {labels.shape}")


def camera_side(points: FloatArray, valid: MaskArray) -> int:
    """Return +1 where z points towards the camera, -1 where away from it.

    In the camera frame every z is the distance, comparable to the width that is seen; in the membrane frame z is an
    indentation, small beside that width. A sample of the pixels decides.
    """
    step = max(1, round((valid.size / 2000) ** 0.5))
    seen = points[::step, ::step][valid[::step, ::step]]
    if len(seen) < 2:
        return 1
    x, y, z = seen.T
    # Pixels that are saturated seem to be far to the side.
    width = max(quantile(w, 0.95) - quantile(w, 0.05) for w in (x, y)) / 0.9
    return -1 if quantile(z) > CAMERA_RATIO * width else 1


def finite(points: FloatArray, valid: MaskArray) -> MaskArray:
    """Return which valid points (h, w, 3) are finite; a reduction over so short an axis takes twenty times as long."""
    return valid & np.isfinite(points[..., 0]) & np.isfinite(points[..., 1]) & np.isfinite(points[..., 2])


def clean(points: FloatArray, valid: MaskArray, towards: int = 0, *, square: bool = True) -> Cleaned | None:
    """Crop points (h, w, 3), m, to their valid pixels, and drop those that fly, are saturated or not finite.

    None where no two valid pixels touch; InvalidInput where the points are in another unit, or, with `square`, their pixels are not square.

    `towards` says where z points, as `camera_side` does; 0 asks that.
    """
    from stretch_bt.perception.surface_kernel import fill_height

    check_points(points, valid)
    box = valid_box(valid)
    near = points[box]
    seen = finite(near, valid[box])
    pitch = pitch_of(near, seen)
    if pitch == 0.0:
        return None
    check_pitch(pitch)
    if square:
        check_square(near, seen, pitch)
    towards = towards or camera_side(near, seen)
    level = quantile(sample(near[..., 2], seen))
    precision = np.float32 if points.dtype.itemsize <= 4 else np.float64
    rows = np.require(points, precision, ["C", "W"]).reshape(len(points), -1)
    height = np.empty(seen.shape, dtype=np.float32)
    fill_height(rows, seen, box[0].start, box[1].start, level, towards, height)
    near_by = seen & (
        np.abs(height) < pitch * max(seen.shape)
    )  # no saturated pixels, nor what is far behind the membrane
    kept = near_by & ~flying_pixels(height, near_by, pitch)
    return Cleaned(height, seen, kept, rows, box, valid.shape, pitch, towards * level, towards)


def surface_of(points: FloatArray, valid: MaskArray, kernel: float) -> Surface | None:
    """Prepare points (h, w, 3), m, for derivatives with a Gaussian of `kernel`, m; None where too few are valid."""
    cleaned = clean(points, valid)
    return None if cleaned is None else binned_surface(cleaned, kernel)


def binned_surface(cleaned: Cleaned, kernel: float, noise: tuple[float, float] | None = None) -> Surface:
    """Return the surface in bins as wide as the kernel allows, which costs less and says the same.

    `noise` of one pixel, m, and the length over which it is shared, pixels, are measured unless they are given: best with
    a narrow kernel, which leaves least of the surface in the residual.
    """
    from stretch_bt.perception.surface_kernel import fill_surface

    if not (is_number(kernel) and 0.0 < kernel < LARGEST_KERNEL):
        raise InvalidInput(f"a kernel is a length in m above 0 and below {LARGEST_KERNEL}, got {shown(kernel)[:80]}")
    pixels = kernel / cleaned.pitch
    step = 2 ** max(0, math.floor(math.log2(max(pixels, 1.0) / LEAST_SIGMA)))
    # A bin spreads a pixel by (step^2 - 1) / 12 already.
    sigma = math.sqrt(max(pixels**2 - (step**2 - 1) / 12.0, 0.0)) / step
    sigma = float(np.clip(round(20.0 * sigma) / 20.0, 1.5, MOST_SIGMA))
    raw, share = cleaned.bins(step)
    mean, cover = covered(raw, share, sigma)
    height, valid, trusted = np.empty_like(raw), np.empty(raw.shape, dtype=bool), np.empty(raw.shape, dtype=bool)
    fill_surface(mean, cover, raw, share, COVER, ONE_SIDED / sigma, height, valid, trusted)
    pitch = step * cleaned.pitch
    view = cleaned.pitch * max(cleaned.valid.shape)
    lines, (pixel, length) = cleaned.stripes, noise or _noise(cleaned, height - mean, valid, mean, step, sigma)
    level, towards = cleaned.level, cleaned.towards
    return Surface(height, mean, valid, trusted, level, pitch, sigma, step, pixel, length, towards, view, (0, 0), lines)


def _noise(
    cleaned: Cleaned, rest: Image, valid: MaskArray, mean: Image, step: int, sigma: float
) -> tuple[float, float]:
    """Return the noise of one pixel, m, and the length over which pixels share it, from the residual to the mean."""
    again = derivative(rest, sigma, 0, 0)
    shared, length = noise_of(without_lines(rest - again, valid, cleaned.stripes), valid, sigma)
    if length < SHARED:
        return _pixel_noise(cleaned, mean + again, step, sigma), 0.0
    return shared, step * length


def _pixel_noise(cleaned: Cleaned, mean: Image, step: int, sigma: float) -> float:
    """Return the noise of one pixel, m, if it is white, from some pixels beside the smoothed height at their places."""
    (h, w), every = mean.shape, max(1, round((mean.size / 4000) ** 0.5))
    rows, columns = slice(1, h - 1, every), slice(1, w - 1, every)
    down = mean[2::every, columns] - mean[: h - 2 : every, columns]
    along = mean[rows, 2::every] - mean[rows, : w - 2 : every]
    offset = -0.25 * (step - 1) / step  # half the way to a bin's first pixel from its middle
    first = slice(step, step * (h - 1), step * every), slice(step, step * (w - 1), step * every)
    residual, seen = cleaned.height[first] - mean[rows, columns] - offset * (down + along), cleaned.valid[first]
    if not seen.any():
        return 0.0
    own = without_lines(residual, seen, cleaned.stripes)[seen]
    return MAD_TO_SD * quantile(np.abs(own)) / math.sqrt(left_of_one(sigma, step))
