"""Closed curves as arrays of complex numbers x + iy: length, area, even sampling, smoothing that keeps corners."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

__all__ = [
    "Array",
    "Curve",
    "area_of",
    "even",
    "lengthened",
    "noise_of",
    "perimeter_of",
    "redrawn",
    "smoothed",
    "spacing_of",
]

Curve = npt.NDArray[np.complex128]
Array = npt.NDArray[np.float64]

HALF_WIDTHS = (1, 2, 3, 4, 5, 7, 9, 12, 16, 22, 30)  # samples to either side, from none used to many
NOISE_HALF_WIDTH = 5  # samples over which noise and shape are separated
STRAY = 3.2  # standard deviations that a wider fit may differ before the boundary is taken to bend
GIVEN_BACK = 0.75  # share of what smoothing took that a second pass returns: less bias at corners for a little noise
UNEVEN = 3.0  # longest over median gap, over a few samples, from which an outline is sampled anew
LEAST, MOST = 16, 20000  # samples
LEAST_SIDE = 0.3  # least length of a side that counts, as a share of the usual one
REDRAWN = 8  # curves of other noise, whose mean is the expected value


def area_of(curve: Curve) -> float:
    """Return the area that a closed polygon encloses."""
    return abs(0.5 * float((np.conj(curve) * np.roll(curve, -1)).imag.sum()))


def perimeter_of(curve: Curve) -> float:
    """Return the length of a closed polygon."""
    return float(np.abs(np.roll(curve, -1) - curve).sum())


def _gaps(curve: Curve) -> Array:
    """Return the distance from each sample to the next, over several of them, which noise across lengthens but little."""
    lag = max(1, min(4, len(curve) // 8))
    return np.asarray(np.abs(np.roll(curve, -lag) - curve) / lag)


def spacing_of(curve: Curve) -> float:
    """Return the typical distance between samples along the curve."""
    return float(np.median(_gaps(curve)))


def even(curve: Curve, gap: float | None = None) -> Curve:
    """Return the polygon sampled evenly along its length at about `gap`; without one, as it is unless that is uneven."""
    sides = np.abs(np.roll(curve, -1) - curve)
    if gap is None:
        if _gaps(curve).max() <= UNEVEN * spacing_of(curve):
            return curve
        gap = float(np.median(sides))
    along = np.concatenate([[0.0], np.cumsum(sides)])
    count = int(min(max(along[-1] / gap, LEAST), MOST))
    places = np.arange(count) * (along[-1] / count)
    closed = np.append(curve, curve[0])
    sampled: Curve = np.interp(places, along, closed.real) + 1j * np.interp(places, along, closed.imag)
    return sampled


@lru_cache(maxsize=64)
def _weights(half: int) -> Array:
    """Return the weights with which a least-squares quadratic over 2 half + 1 samples gives its middle (Savitzky and Golay, 1964)."""
    k = np.arange(-half, half + 1.0)
    if half == 1:
        return np.array([0.0, 1.0, 0.0])  # a parabola through three samples
    moments = np.vander(k, 3, increasing=True)
    return np.asarray(np.linalg.pinv(moments)[0])


@lru_cache(maxsize=8)
def _spectra(count: int) -> Array:
    """Return (k, count): the factors of each fit of a closed curve on its frequencies."""
    rows = np.zeros((len(_half_widths(count)), count))
    for row, half in zip(rows, _half_widths(count), strict=True):
        weights = _weights(half)
        row[: half + 1], row[-half:] = weights[half:], weights[:half]
    return np.ascontiguousarray(np.fft.fft(rows).real)


@lru_cache(maxsize=8)
def _sizes(count: int) -> Array:
    """Return (k, 1): the standard deviations of the fits of white noise of 1."""
    return np.array([[float(np.linalg.norm(_weights(half)))] for half in _half_widths(count)])


def _fits(curve: Curve) -> Curve:
    """Return (k, n): the local quadratics of each half width at the samples of a closed curve (n,)."""
    return np.asarray(np.fft.ifft(np.fft.fft(curve) * _spectra(len(curve))))


def _normals(curve: Curve) -> Curve:
    lag = max(1, min(4, len(curve) // 8))
    along = np.roll(curve, -lag) - np.roll(curve, lag)
    size = np.abs(along)
    return np.asarray(1j * along / np.where(size > 0, size, 1.0))


def _half_widths(count: int) -> list[int]:
    return [half for half in HALF_WIDTHS if 2 * half + 1 <= count // 3]


def _noise_sd(curve: Curve, normal: Curve, fits: Curve) -> float:
    """Return the standard deviation across the curve, from the residuals to a local quadratic; a few corners do not count."""
    halves = [half for half in _half_widths(len(curve)) if half <= NOISE_HALF_WIDTH]
    left = ((curve - fits[len(halves) - 1]) * np.conj(normal)).real
    share = 1.0 - float(_weights(halves[-1])[halves[-1]])
    return 1.4826 * float(np.median(np.abs(left))) / np.sqrt(share) if share > 0 else 0.0


def smoothed(curve: Curve) -> Curve:
    """Return a curve of at least 16 even samples without its noise, its corners kept.

    At each sample the widest local quadratic is taken that still agrees with all narrower ones within their errors
    (Goldenshluger and Nemirovski, 1997; Katkovnik, 1999), with the noise that the curve itself shows.
    """
    fits = _fits(curve)
    return _taken(curve, fits, _widths(curve, fits))


def _widths(curve: Curve, fits: Curve) -> npt.NDArray[np.int64]:
    """Return which of the fits (k, n) is taken at each sample, (n,)."""
    normal = _normals(curve)
    shift = ((fits - curve) * np.conj(normal)).real
    reach = STRAY * _noise_sd(curve, normal, fits) * _sizes(len(curve))
    low, high = np.maximum.accumulate(shift - reach), np.minimum.accumulate(shift + reach)
    agree = np.logical_and.accumulate(low <= high).sum(axis=0)
    return np.asarray(np.maximum(agree - 1, 0))


def _taken(curve: Curve, fits: Curve, which: npt.NDArray[np.int64]) -> Curve:
    """Return a curve (n,) with the fits (k, n) that are taken, and a part of the residuals to them."""
    at = np.arange(len(which))
    found = fits[which, at]
    return np.asarray(found + GIVEN_BACK * _fits(curve - found)[which, at])


def lengthened(curve: Curve) -> float:
    """Return the expected relative excess length of a smoothed curve due to the noise that smoothing has left.

    A side is longer by half the square of how much its ends stray from each other across it, over its length.
    """
    fits = _fits(curve)
    which = _widths(curve, fits)
    inside = _taken(curve, fits, which)
    sides = np.roll(inside, -1) - inside
    lengths = np.maximum(np.abs(sides), LEAST_SIDE * spacing_of(inside))
    noise = redrawn(curve, REDRAWN) - inside
    strays = np.array([_taken(each, _fits(each), which) for each in noise])
    across = ((np.roll(strays, -1, axis=-1) - strays) * np.conj(sides)).imag / lengths
    return float(np.mean(np.sum(across**2 / lengths, axis=-1))) / 2.0 / perimeter_of(inside)


def noise_of(curve: Curve) -> tuple[float, float]:
    """Return the standard deviation of a curve's noise across it, and its correlation from one sample to the next."""
    normal, fits = _normals(curve), _fits(curve)
    left = ((curve - _taken(curve, fits, _widths(curve, fits))) * np.conj(normal)).real
    sd = max(_noise_sd(curve, normal, fits), 1.4826 * float(np.median(np.abs(left))))
    left = np.clip(left, -STRAY * sd, STRAY * sd)
    power = float(left @ left)
    return sd, float(np.clip(left @ np.roll(left, 1) / power, 0.0, 0.9)) if power > 0 else 0.0


def redrawn(curve: Curve, count: int, least: float = 0.0) -> Curve:
    """Return (count, n): curves as this one might as well have come out, with other noise of the same kind, of a standard deviation at least."""
    rng = np.random.default_rng(0)
    sd, correlation = noise_of(curve)
    sd = max(sd, least)
    white = rng.normal(size=(count, len(curve)))
    # An autoregression of first order around the closed curve, as a filter of unit power.
    gain = 1.0 / np.abs(1.0 - correlation * np.exp(-2j * np.pi * np.fft.rfftfreq(len(curve))))
    noise = np.fft.irfft(np.fft.rfft(white) * gain, n=len(curve)) * np.sqrt(1.0 - correlation**2)
    inside = smoothed(curve)
    return np.asarray(inside + sd * noise * _normals(inside))
