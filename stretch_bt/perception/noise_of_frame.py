"""The noise of a frame over several lengths, from its residuals to Gaussian means of three widths."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.noise_off_contact import COARSE, LeftByEllipse, left_by_ellipse
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.smooth import covered, derivative, least_seen
from stretch_bt.perception.stripes import NO_STRIPES, without_lines
from stretch_bt.perception.surface import Cleaned
from stretch_bt.perception.types import MaskArray

__all__ = ["noise_spectrum"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]

LENGTHS = (0.0, 1.0, 2.0, 3.0, 4.5, 6.5, 9.0)  # pixels
Width = tuple[int, float, int]  # of bins and of the Gaussian, pixels, and how often it is taken away
WIDTHS: tuple[Width, ...] = ((1, 3.0, 2), (2, 4.5, 2), (4, 9.0, 3))
COARSE_LENGTHS = 5  # of LENGTHS, of pixels wider than COARSE, m
WIDEST = 4.0e-3  # m, of a Gaussian: the membrane bends over such lengths, however many pixels they are
NARROWEST = 3.0, 1.5  # pixels and bins, of a Gaussian
LAGS = 4
#: share of a residual that noise of each length must explain: the longest differ little from membrane, and from chance
LEAST_SHARE = (0.0, 0.02, 0.02, 0.02, 0.05, 0.1, 0.15)
FREE_SHARE = (0.0, *[0.02] * 6)  # the same with residuals to ellipses, which hold no membrane
MOST = 96  # bins along a side that are looked at
CUT = 3.0  # standard deviations past which a residual is no noise: a rim, or a pixel that flies
WHOLE = 0.97  # share of the kernel that must see valid pixels
# where dropouts leave less than that of any kernel: how much less than USUAL of the kernels see a kernel, or a bin, may see
USUAL, LESS = 0.9, 0.02
LEAST = 60  # fewest bins for a width
ROUNDS = 4  # of variances, and the errors of sums of squares that follow from them
SHORT = 3  # lengths that narrow means separate from membrane
LONG = 4  # lengths that only the widest mean shows, and takes part of for membrane
# logarithm of the variance that an ellipse leaves over what it would leave of the noise that means show: below the first it is chance, a kink
# or a clamp, and from the second noise
DOUBT = (0.45, 0.9)
LEAST_SIZE = 0.3  # least size of a sum of squares for its error, as a share of the sum
SWEEPS, SETTLED = 100, 1e-5


def noise_spectrum(cleaned: Cleaned, apart: MaskArray | None = None, free: MaskArray | None = None) -> NoiseSpectrum:
    """Return the noise of a frame.

    The covariance of the residuals to means of some widths, a few pixels apart, is compared with the one that noise of each length
    leaves; least squares that are not negative give the variances. Noise alike over more than some ten pixels, or five of those
    wider than 0.55 mm, passes for membrane, and without `free` a part of the noise alike over more than half as many.

    Parameters
    ----------
    apart : (h, w) bool, of the cleaned part
        Where the membrane bends least, as away from the contact: the widest mean is compared there only, if that is enough.
    free : (h, w) bool, of the cleaned part
        Where the membrane touches nothing: there the mean over an ellipse separates noise of up to some 9 pixels, or 5 wide ones, from
        membrane. It counts where means show noise of more than 3 pixels, and where its residual is clearly more than the noise that they
        show.
    """
    rows, found, widths = list[Array](), list[Array](), _widths(cleaned.pitch)
    lengths = LENGTHS[:COARSE_LENGTHS] if cleaned.pitch > COARSE else LENGTHS
    for step, width, times in widths:
        seen = _left(cleaned, step, width, times, apart if times == WIDTHS[-1][2] else None)
        if seen is not None and seen[0] > 0.0:
            rows.append(_expected(step, width, times)[:, : len(lengths)] / seen[0])
            found.append(seen / seen[0])
    if not rows:
        return NoiseSpectrum(np.zeros(1), np.zeros(1), cleaned.stripes)
    variances = _not_negative(np.concatenate(rows), np.concatenate(found))
    if free is not None:
        variances = _with_ellipse(cleaned, free, lengths, rows, found, variances)
    return NoiseSpectrum(variances, np.array(lengths), cleaned.stripes)


def _widths(pitch: float) -> tuple[Width, ...]:
    """Return WIDTHS, or narrower ones where pixels are so wide, m, that the membrane bends over them."""
    if pitch <= COARSE:
        return WIDTHS
    widest = max(WIDEST / pitch, NARROWEST[0])
    return tuple(
        (min(step, 1 << int(math.log2(min(width, widest) / NARROWEST[1]))), min(width, widest), times)
        for step, width, times in WIDTHS
    )


def _with_ellipse(
    cleaned: Cleaned,
    free: MaskArray,
    lengths: tuple[float, ...],
    rows: list[Array],
    found: list[Array],
    variances: Array,
) -> Array:
    """Return variances (k,), m^2, by means alone, by an ellipse too where noise is long, or in part, as far as the ellipse shows that it is."""
    is_long = bool(variances[LONG:].any())
    left = left_by_ellipse(cleaned, free, lengths, (0.0 if is_long else math.exp(DOUBT[0])) * variances)
    if left is None:
        return variances
    few = slice(len(WIDTHS) - 1)
    other = _of_ellipse(left, lengths, np.concatenate(rows[few]), np.concatenate(found[few]), variances)
    if is_long:
        return other
    more = math.log(left.variances[-1] / max(float(left.expected(lengths)[-1] @ variances), 1e-30))
    trust = min((more - DOUBT[0]) / (DOUBT[1] - DOUBT[0]), 1.0)
    return np.asarray(variances + trust * (other - variances))


def _of_ellipse(left: LeftByEllipse, lengths: tuple[float, ...], rows: Array, found: Array, variances: Array) -> Array:
    """Return variances (k,), m^2, that explain the residuals to narrow means and an ellipse; each sum of squares errs in proportion to itself."""
    wanted = left.expected(lengths)
    short = wanted[:, :SHORT] @ variances[:SHORT]  # that membrane does not hide
    seen = np.maximum(left.variances, short)
    for _ in range(ROUNDS):
        size = np.maximum(wanted @ variances, LEAST_SIZE * seen)
        design = np.concatenate([rows, wanted / size[:, None]])
        variances = _not_negative(design, np.concatenate([found, seen / size]), FREE_SHARE)
    return variances


def _left(cleaned: Cleaned, step: int, width: float, times: int, apart: MaskArray | None) -> Array | None:
    """Return the covariance (LAGS,), m^2, of the residual of bins to the mean of a width, with itself 0, 1 ... bins aside and below."""
    raw, share = (_middle(image) for image in cleaned.bins(step))
    sigma = _sigma(step, width)
    rest = raw
    for _ in range(times):
        mean, cover = covered(rest, share, sigma)
        rest = np.where(share > 0.0, rest - mean / np.maximum(cover, np.float32(1e-3)), np.float32(0))
    seen = derivative(share, sigma * math.sqrt(times), 0, 0)
    least = least_seen(seen[share > 0.0], 1.0, LESS, USUAL)
    whole = (share > least) & (seen > min(WHOLE, least))
    if apart is not None:
        far = whole & _middle(apart[::step, ::step])
        whole = far if np.count_nonzero(far) >= LEAST else whole
    if np.count_nonzero(whole) < LEAST:
        return None
    whole &= _is_noise(rest, whole)
    if cleaned.stripes != NO_STRIPES and np.count_nonzero(whole) >= LEAST:
        rest = without_lines(rest, whole, cleaned.stripes)
        whole &= _is_noise(rest, whole)
    rest = np.where(whole, rest, np.float32(0))
    return np.array([_covariance(rest, whole, lag) for lag in range(LAGS)])


def _is_noise(rest: Image, whole: MaskArray) -> MaskArray:
    return np.asarray(np.abs(rest) < CUT * MAD_TO_SD * quantile(np.abs(rest[whole])))


def _middle(image: Any) -> Any:
    """Return the middle of an image, MOST along a side."""
    v, u = (max(0, (n - MOST) // 2) for n in image.shape)
    return np.ascontiguousarray(image[v : v + MOST, u : u + MOST])


def _covariance(rest: Image, seen: MaskArray, lag: int) -> float:
    n = len(rest) - lag, rest.shape[1] - lag
    pairs = int(np.count_nonzero(seen[lag:] & seen[: n[0]]) + np.count_nonzero(seen[:, lag:] & seen[:, : n[1]]))
    total = float(np.vdot(rest[lag:], rest[: n[0]])) + float(np.vdot(rest[:, lag:], rest[:, : n[1]]))
    return total / float(max(pairs, 1))


def _sigma(step: int, width: float) -> float:
    return float(max(1.5, round(20.0 * float(width) / step) / 20.0))


@lru_cache(maxsize=8)
def _expected(step: int, width: float, times: int) -> Array:
    """Return the covariance (LAGS, k) that is left of noise of variance 1 of each length."""
    return np.stack([_of_length(length, step, _sigma(step, width), times) for length in LENGTHS], axis=1)


def _of_length(length: float, step: int, sigma: float, times: int) -> Array:
    if length == 0.0:
        return np.array([_covariance_left(0.0, sigma, times, float(lag)) for lag in range(LAGS)]) / step**2
    own = (length / step) ** 2
    wider = own + (1.0 - 1.0 / step**2) / 12.0  # the bins blur as a Gaussian of their own variance does
    return own / wider * np.array([_covariance_left(wider, sigma, times, float(lag)) for lag in range(LAGS)])


def _covariance_left(square: float, sigma: float, times: int, d: float) -> float:
    """Return the covariance, at a distance d, of noise of variance 1 once its mean is subtracted, some times.

    The noise is white, or white noise after a Gaussian whose squared length is given; the power that is left is (1 - g)^(2 times).
    """
    total = 0.0
    for m in range(2 * times + 1):
        weight = math.comb(2 * times, m) * (-1.0) ** m
        spread = 2.0 * square + m * sigma**2
        if square == 0.0:
            near = float(d == 0.0) if m == 0 else math.exp(-(d**2) / (2.0 * spread)) / (2.0 * math.pi * spread)
        else:
            near = 2.0 * square / spread * math.exp(-(d**2) / (2.0 * spread))
        total += weight * near
    return total


def _not_negative(design: Array, wanted: Array, least: tuple[float, ...] = LEAST_SHARE) -> Array:
    """Return least squares (k,) of design (n, k) that are not negative, of the columns that explain at least their share."""
    size = np.sqrt((design * design).sum(axis=0))
    scaled = design / size
    normal, right = scaled.T @ scaled, scaled.T @ wanted
    some = _descent(normal, right - np.array(least[: len(right)]), np.ones(len(right), dtype=bool)) > 0.0
    found: Array = _descent(normal, right, some) / size
    return found


def _descent(normal: Array, right: Array, free: MaskArray) -> Array:
    """Return q (k,) of least q . normal . q / 2 - right . q that is not negative, and 0 where not free (Franc et al., 2005)."""
    from stretch_bt.perception.noise_spectrum_kernel import descend

    q = np.zeros(len(right))
    descend(np.ascontiguousarray(normal), right, free, SWEEPS, SETTLED, q)
    return q
