"""Noise of long correlation, measured where the membrane is free: there its mean over an ellipse is its height in the middle.

The free membrane obeys T_i z_xx + T_j z_yy = 0 (the shallow membrane). With y scaled by sqrt(T_i / T_j) it is harmonic, and the mean of a
harmonic function over a disc is its value in the middle of the disc. The middle less the mean over an ellipse of that shape is therefore noise,
however steep the membrane is, and noise of a length up to half the ellipse passes nearly whole.

No surface is quite harmonic: a steep sheet is not shallow, and a clamp bends it. That error grows with the curvature of the membrane, and noise
is alike everywhere, so that the variance of the residual is taken at no curvature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.smooth import covered, derivative, gaussian, shrink, smooth
from stretch_bt.perception.stripes import NO_STRIPES, Stripes
from stretch_bt.perception.surface import Cleaned
from stretch_bt.perception.types import MaskArray

__all__ = ["LeftByEllipse", "left_by_ellipse"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]

STEPS = 4, 2  # pixels of a bin, by side, and of one of pixels wider than COARSE; powers of 2
COARSE = 0.55e-3  # m
RADIUS = 4.0  # bins, the geometric mean of the semi-axes: the noise that passes is up to half as long
RATIOS: tuple[float, ...] = tuple(np.geomspace(1.0, 5.0, 9).tolist())  # of the semi-axes along j and i
FIRST = (4, 2, 6, 0, 8)  # of RATIOS, the likeliest first
# bins; Gaussians after which the variance of the residual is taken, as bins alone hold more white noise than long
MEANS = (1.0, 2.0)
BENT = 2.0  # bins; of the Gaussian with which curvatures are seen
SEEN = 0.8  # share of a bin's pixels that must be valid
WHOLE = 0.95  # share of the ellipse that must be valid
LEAST = 60  # fewest bins of a residual
CUT, ROUNDS = 3.5, 3  # standard deviations past which a residual is no noise, and how often they are taken
AROUND = np.ones((5, 5), dtype=np.uint8)  # bins around such a one that are no noise either
LEAST_KEPT = 0.3  # of the bins
LEAST_LEFT = 0.01  # least share of a variance that remains when the stripes' variance, which is only roughly known, is subtracted
# Variance that the curvature adds at its median, over the noise's; and the gain in log likelihood from which it is believed
BY_CURVATURE: Image = np.array([0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0], dtype=np.float32)
GAIN = 1.0
PATCH = 400.0  # pixels that count as one independent value: as of noise alike over 5.6 pixels


@dataclass(frozen=True, slots=True)
class LeftByEllipse:
    """Variances (k,), m^2, of the residual to an ellipse after each of MEANS, with the `ratio` of its semi-axes and the pixels of a bin."""

    variances: Array
    ratio: float
    step: int

    def expected(self, lengths: tuple[float, ...]) -> Array:
        """Return the same variances (k, n) for noise of variance 1 of each length, pixels."""
        return _expected(self.ratio, self.step, lengths)


@dataclass(frozen=True, slots=True)
class _Free:
    """Bins (h, w) of `step` pixels: height, share that is valid, places, slopes along both, and where the membrane touches nothing."""

    step: int
    height: Image
    share: Image
    places: tuple[Image, Image]
    slopes: tuple[Image, Image]
    bends: tuple[Image, Image, Image]  # second differences along u and v and of both, m
    free: Image


def left_by_ellipse(
    cleaned: Cleaned, free: MaskArray, lengths: tuple[float, ...], enough: Array
) -> LeftByEllipse | None:
    """Return the residual of a frame to the ellipse that leaves least; None where too little of it is free, or one leaves little enough.

    Parameters
    ----------
    free : (h, w) bool, of the cleaned part
        Where the membrane touches nothing.
    lengths : pixels
        Lengths of noise; ellipses are compared by their residual over the one that noise of the last length leaves.
    enough : (k,) m^2
        Variances of noise of these lengths: where an ellipse leaves no more than of such noise, nothing more is to be found.
    """
    bins, found = _bins(cleaned, free), dict[int, _View]()

    def least() -> int:
        return min(found, key=lambda n: found[n].size(lengths))

    for n in FIRST:
        found[n] = _View(bins, RATIOS[n], cleaned.stripes)
        if found[n].leaves_no_more(lengths, enough):
            return None
    best = least()
    found |= {n: _View(bins, RATIOS[n], cleaned.stripes) for n in (best - 1, best + 1) if 0 <= n < len(RATIOS)}
    view = found[least()]
    if view.leaves_no_more(lengths, enough):
        return None
    left = np.array([view.variance(k) for k in range(len(MEANS))])
    return LeftByEllipse(left, view.ratio, bins.step) if np.isfinite(left).all() and left.all() else None


def _bins(cleaned: Cleaned, free: MaskArray) -> _Free:
    step = STEPS[cleaned.pitch > COARSE]
    raw, share = cleaned.bins(step)
    points = cleaned.points.reshape(len(cleaned.points), -1, 3)[cleaned.box]
    x, y = (_means(points[..., axis].astype(np.float32), cleaned.valid, step) for axis in range(2))
    filled = np.where(share > 0.0, raw, smooth(raw, share, BENT)[0])
    pitch = np.float32(cleaned.pitch * step)
    slopes = derivative(filled, BENT, 1, 0) / pitch, derivative(filled, BENT, 0, 1) / pitch
    bends = (derivative(filled, BENT, 2, 0), derivative(filled, BENT, 0, 2), derivative(filled, BENT, 1, 1))
    beside = np.zeros(raw.shape, dtype=np.float32)
    cut = free[::step, ::step][: raw.shape[0], : raw.shape[1]]
    beside[: cut.shape[0], : cut.shape[1]] = cut
    return _Free(step, raw, share, (x, y), slopes, bends, beside)


def _means(image: Image, valid: MaskArray, step: int) -> Image:
    mean, share = shrink(np.where(valid, image, np.float32(0)), valid)
    for _ in range(step.bit_length() - 2):
        mean, share = shrink(mean, share)
    return mean


class _View:
    """The residual of bins (h, w), m, to an ellipse, and where it is seen."""

    def __init__(self, bins: _Free, ratio: float, stripes: Stripes) -> None:
        self.ratio, self._step, self._bent, self._stripes = ratio, bins.step, _bent(bins, ratio), stripes
        self._rest, self._whole = _rest(bins, ratio)
        self._last = self.variance(-1)

    def size(self, lengths: tuple[float, ...]) -> float:
        """Return the variance after the last of MEANS, over the one that noise of variance 1 of the last length, pixels, leaves."""
        return self._last / float(_expected(self.ratio, self._step, lengths)[-1, -1])

    def leaves_no_more(self, lengths: tuple[float, ...], variances: Array) -> bool:
        """Whether no more is left after the last of MEANS than of noise of variances (k,), m^2, of the lengths (k,), pixels."""
        return self._last <= float(_expected(self.ratio, self._step, lengths)[-1] @ variances)

    def variance(self, number: int) -> float:
        """Return the variance, m^2, after one of MEANS; infinite where too little is free."""
        total, cover = covered(self._rest, self._whole.astype(np.float32), MEANS[number])
        there = self._whole & (cover > SEEN)
        if np.count_nonzero(there) < LEAST:
            return math.inf
        mean: Image = np.asarray(total / np.maximum(cover, np.float32(1e-3)), np.float32)
        found = _unbent(mean, there, self._bent, self._step)
        if self._stripes == NO_STRIPES:
            return found
        by_rows, by_columns = _of_lines(self.ratio, self._step)[number]
        return max(found - self._stripes.rows * by_rows - self._stripes.columns * by_columns, LEAST_LEFT * found)


def _rest(bins: _Free, ratio: float) -> tuple[Image, MaskArray]:
    """Return the height of the middle less the mean over an ellipse around it (h, w), m, and where that is seen.

    Rows and columns of a camera are no even places, so that a slope makes a difference as well, which is taken away.
    """
    import cv2

    kernel = _ellipse(ratio)

    def mean(image: Image) -> Image:
        return np.asarray(cv2.filter2D(image, cv2.CV_32F, kernel, borderType=cv2.BORDER_CONSTANT))

    cover = mean(bins.share)
    whole = (cover > WHOLE) & (mean(bins.free) > 0.999) & (bins.share > SEEN)
    cover = np.maximum(cover, np.float32(1e-3))
    rest = bins.height - mean(bins.height * bins.share) / cover
    for place, slope in zip(bins.places, bins.slopes, strict=True):
        rest += slope * (mean(place * bins.share) / cover - place)
    return np.where(whole, rest, np.float32(0)), np.asarray(whole)


def _bent(bins: _Free, ratio: float) -> Image:
    """Return the squared curvature (h, w) of the membrane, in a unit of its own.

    With noise that is alike in all directions it does not correlate with the residual in the same
    place: E[z_xx z_yy] is a third of E[z_xx^2] = E[z_yy^2].
    """
    along_i, along_j, both = bins.bends
    k = ratio**2
    saddle = ((1.0 + 3.0 * k) * along_i - (3.0 + k) * along_j) / (8.0)
    return np.asarray(saddle * saddle + k * both * both, dtype=np.float32)


def _unbent(rest: Image, there: MaskArray, bent: Image, step: int) -> float:
    """Return the variance, m^2, that a residual (h, w) has where it is seen and nothing is bent: the likeliest s^2 (1 + a c) of a curvature c."""
    kept = _kept(rest, there)
    square, c = rest[kept] ** 2, bent[kept]
    grows = 1.0 + BY_CURVATURE[:, None] * (c / np.float32(max(quantile(c), 1e-30)))
    shares = np.mean(
        square / grows, axis=1, dtype=np.float64
    )  # no product of BLAS, whose last digits are the processor's
    variance = np.maximum(shares, 1e-24)
    count = square.size * step**2 / PATCH
    likely = -0.5 * count * (np.log(variance) + np.log(grows).mean(axis=1))
    best = int(likely[1:].argmax()) + 1
    return float(variance[best if likely[best] > likely[0] + GAIN else 0])


def _kept(rest: Image, there: MaskArray) -> MaskArray:
    """Return where a residual is noise: bins that stand out, and the bins around them, are a rim or a clamp."""
    import cv2

    size = np.abs(rest)
    kept, sd = there, MAD_TO_SD * quantile(size[there])
    least = max(LEAST_KEPT * np.count_nonzero(there), LEAST)
    for _ in range(ROUNDS):
        out = (there & (size > CUT * sd)).view(np.uint8)
        less = there & (cv2.dilate(out, AROUND) == 0)
        if np.count_nonzero(less) < least:
            break
        kept, sd = less, math.sqrt(float(np.mean(rest[less] ** 2)))
    return np.asarray(kept)


@lru_cache(maxsize=len(RATIOS))
def _ellipse(ratio: float) -> Image:
    """Return the mean over an ellipse as a kernel of bins, of odd shape."""
    half_i, half_j = (RADIUS * factor for factor in (1.0 / math.sqrt(ratio), math.sqrt(ratio)))
    v, u = (np.arange(-math.ceil(half), math.ceil(half) + 1) for half in (half_j, half_i))
    past = (1.0 - np.hypot(u[None, :] / half_i, v[:, None] / half_j)) * min(half_i, half_j)
    inside = np.clip(past + 0.5, 0.0, 1.0)
    return np.asarray(inside / inside.sum(), dtype=np.float32)


@lru_cache(maxsize=2 * len(RATIOS))
def _of_lines(ratio: float, step: int) -> tuple[tuple[float, float], ...]:
    """Return the variances, after each of MEANS, of the residual to an ellipse of rows and of columns of pixels, each of variance 1."""
    found = []
    for kernel in _kernels(ratio):
        across_rows, across_columns = kernel.sum(axis=1), kernel.sum(axis=0)
        found.append((float(across_rows @ across_rows) / step, float(across_columns @ across_columns) / step))
    return tuple(found)


@lru_cache(maxsize=len(RATIOS))
def _kernels(ratio: float) -> tuple[Array, ...]:
    """Return, after each of MEANS, the residual of a bin to an ellipse."""
    left = -_ellipse(ratio).astype(np.float64)
    left[left.shape[0] // 2, left.shape[1] // 2] += 1.0
    lines = (gaussian(mean, 0) for mean in MEANS)
    return tuple(_whole(left, np.outer(line, line)) for line in lines)


@lru_cache(maxsize=2 * len(RATIOS))
def _expected(ratio: float, step: int, lengths: tuple[float, ...]) -> Array:
    """Return the variances (k, n) of the residual to an ellipse, after each of MEANS, of noise of variance 1 of each length, pixels."""
    rows = []
    for kernel in _kernels(ratio):
        own = _whole(kernel, kernel[::-1, ::-1])
        v, u = np.indices(own.shape) - (np.array(own.shape) // 2)[:, None, None]
        rows.append([float((own * _alike(np.hypot(v, u), length, step)).sum()) for length in lengths])
    return np.array(rows)


def _whole(one: Array, other: Array) -> Array:
    """Return the convolution of two images of odd shape, as far as it reaches."""
    from scipy.ndimage import convolve

    rows, columns = (size // 2 for size in other.shape)
    return np.asarray(convolve(np.pad(one, ((rows, rows), (columns, columns))), other, mode="constant"))


def _alike(away: Array, length: float, step: int) -> Array:
    """Return the covariance of bins of `step` pixels so many bins apart, of noise of variance 1 of a length, pixels."""
    if length == 0.0:
        return np.asarray((away == 0.0) / step**2)
    square = length**2 / step**2
    wider = square + (1.0 - 1.0 / step**2) / 12.0  # the bins blur as a Gaussian of their own variance does
    return np.asarray(square / wider * np.exp(-(away**2) / (4.0 * wider)))
