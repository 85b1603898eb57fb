"""Height of a flat top that leans, in its middle, whatever part of it was taken for contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.regions import closed
from stretch_bt.perception.smooth import least_seen, medians
from stretch_bt.perception.steps import step_of
from stretch_bt.perception.top import Places, Points, Top, settled
from stretch_bt.perception.types import FloatArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["STEEPEST", "Lean", "lean_of", "radius_of", "share_beyond"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]

SEEN, HOLE = 0.9, 3  # share of such a mean that must have depth; pixels along a side, of holes in a face that are none
LEAST_WIDE = 5  # pixels along a side, of the means that are compared with the plane
LENGTHS = 2.0  # width of such a mean, in sides of a square of pixels that share one error
SHARE = 0.4  # share of a side of the contact: largest width of such a mean
MEDIAN = 5  # pixels along a side, of the median that takes the place of single wild ones
WILD = 4.0  # standard deviations of noise, past which a pixel is wild
BESIDE = 2.5  # standard deviations of a mean, within which it lies in the plane
LEAST_BESIDE = 0.1e-3  # m, this bound at least; the membrane's own bend at a rim shows no more
AROUND = 1.5  # sides of the contact, within which the face is looked for
MOST_SIDE = 200  # means along a side of the window
GROWTH = 4  # means, largest growth of the face in a round
ROUNDS = 24
LEAST = 30  # means of a face
MOST = 2_500  # means, enough to fit a plane well
SAME = 0.005  # share of the means that still change where it has settled
CLEARLY = 3.0  # standard deviations of a lean, and of a bend
BENT = 7.8  # chi2 of three values beyond which 5 % lie: a face that is taken for bent costs less than a flank that is taken for a face
ABOVE, OTHERS = (
    3.0,
    0.02,
)  # times the bound beside a plane, and share of the contact so far above it that another body stands there
SLIGHT = 0.25  # bend over the rise of a face, below which it is its rim's
STEEPEST = math.tan(
    math.radians(10.0)
)  # steepest slope of a top: a steeper one is a flank, from which the membrane hangs
HELD = 0.7  # share of the contact that lies in the plane of a face
WHOLE = 2.5  # times the contact: a plane that ends where the face does, and not somewhere down the skirt, holds less
CLEAR = 0.06  # share of the distance between the middles of contact and plane: twice the bound changes it by less where the plane ends clearly
# Standard deviations, as parts of this distance: of the plane's middle, and of the contact's where the plane does not end clearly; and as a part
# of the rise of a contact, where noise hides the plane: set over the first 24 surfaces of each row of `python benchmarks/leaning_tops.py`.
OFF, OFF_UNCLEAR, OFF_HIDDEN = 0.15, 0.8, 0.6
RIM = 0.4e-3  # m, error of the place of a face's middle, as the membrane leaves a rim in a round
FARTHEST = 1.2  # largest distance between the middles, in radii of the face times the slope
FINE = 0.25e-3  # m: below such a bound noise is too little to hide where the plane ends
SMOOTH = 1.5  # factor: errors that are alike over a part of a plane tilt it more than independent ones do


class _Plane(NamedTuple):
    """z = height + a (x - x0) + b (y - y0); `size`, m, is the rms distance of its points from its middle, along an axis."""

    height: float
    a: float
    b: float
    x0: float
    y0: float
    size: float

    def at(self, x: npt.NDArray[np.floating], y: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
        return np.asarray(self.height + self.a * (x - self.x0) + self.b * (y - self.y0))

    @property
    def slope(self) -> float:
        return math.hypot(self.a, self.b)


@dataclass(frozen=True, slots=True)
class Lean:
    """How a flat top leans: `height`, m, of the middle of its face, None where that is not seen.

    `unseen`, m, is then the standard deviation of the contact's height, as the contact may be the high part of the face alone;
    `is_hidden` says that noise hides the rest of its plane, so that a contact with skirt in it looks alike. `slope` is the slopes along x and y
    of the plane of the contact, with their standard deviation.
    """

    height: Estimate | None
    unseen: float
    is_hidden: bool = False
    slope: tuple[Array, float] | None = None

    def of(self, top: Estimate) -> Estimate:
        """Return the height of the top, m, when the contact alone gives `top`, m, as its height."""
        return self.height or Estimate(top.value, math.hypot(top.sd, self.unseen))


def lean_of(points: FloatArray, valid: MaskArray, touching: MaskArray, noise: NoiseSpectrum, top: Estimate) -> Lean:
    """Return how the flat top under the pixels in contact (h, w) leans, if it does.

    `top`, m, is the height of their middle. They are a part of the face only where its high edge alone bends the membrane clearly.
    """
    seen = _seen(points, valid, touching, noise)
    is_fine = seen.beside < FINE
    found = _by_plane(points, seen, noise, top) if is_fine else Lean(None, 0.0)
    start = _plane(seen, seen.start, MOST)
    if start is None:
        return found
    sd = _slope_sd(start, int(np.count_nonzero(seen.start)) * seen.every**2, noise)
    slope = np.array([start.a, start.b]), sd
    if is_fine:
        return replace(found, slope=slope)
    return Lean(None, OFF_HIDDEN * math.sqrt(max(start.slope**2 - 2.0 * sd**2, 0.0)) * seen.radius, True, slope)


def _by_plane(points: FloatArray, seen: _Seen, noise: NoiseSpectrum, top: Estimate) -> Lean:
    """Return how a top leans by the face in the plane of its contact."""
    face = _leaning(seen, noise)
    if face is None:
        return Lean(None, 0.0)
    mask, plane, done = face
    apart, clear = _apart(top, seen, mask, plane)
    unseen = OFF_UNCLEAR * abs(apart)
    if _stands_out(seen, plane):
        return Lean(None, 0.0)
    if not _is_held(seen, mask) or _is_bent(points, seen, mask, plane.slope, noise):
        return Lean(None, unseen)
    n = int(np.count_nonzero(mask)) * seen.every**2
    if not (done and clear):
        return Lean(Estimate(top.value, math.hypot(top.sd, unseen)), 0.0)
    sd = math.hypot(max(top.sd, _off(n, noise)), OFF * apart, RIM * plane.slope)
    return Lean(Estimate(top.value - apart, sd), 0.0)


def share_beyond(points: FloatArray, valid: MaskArray, touching: MaskArray, noise: NoiseSpectrum) -> float:
    """Return how many times the pixels in contact (h, w) the face that leans under them holds; 1 where no such face is seen."""
    seen = _seen(points, valid, touching, noise)
    face = _leaning(seen, noise) if seen.beside < FINE else None
    if face is None or not _is_held(seen, face[0]):
        return 1.0
    return max(float(np.count_nonzero(face[0]) / np.count_nonzero(seen.start & seen.seen)), 1.0)


def _leaning(seen: _Seen, noise: NoiseSpectrum) -> tuple[MaskArray, _Plane, bool] | None:
    """Return the face that `_grown` finds where its plane clearly leans, and is no flank, else None."""
    found = _grown(seen)
    if found is None:
        return None
    mask, plane, _ = found
    n = int(np.count_nonzero(mask)) * seen.every**2
    return found if CLEARLY * _slope_sd(plane, n, noise) < plane.slope < STEEPEST else None


def _is_held(seen: _Seen, mask: MaskArray) -> bool:
    """Whether most of a contact lies in its plane."""
    return bool(np.count_nonzero(mask & seen.start) > HELD * np.count_nonzero(seen.start & seen.seen))


def _stands_out(seen: _Seen, plane: _Plane) -> bool:
    """Whether a part of the contact clearly stands above a plane, as another body does."""
    above = (seen.mean - plane.at(seen.x, seen.y))[seen.start & seen.seen] > ABOVE * seen.beside
    return bool(np.count_nonzero(above) > OTHERS * above.size)


def _apart(top: Estimate, seen: _Seen, mask: MaskArray, plane: _Plane) -> tuple[float, bool]:
    """Return how far the middle of a contact lies above the middle of the face in its plane, m, and whether the face ends clearly."""
    wider = _near(seen, plane, mask, 2.0 * seen.beside, 0)
    own, more = (float(plane.at(seen.x[m], seen.y[m]).mean()) for m in (mask, mask if wider is None else wider))
    grew = np.count_nonzero(mask) / np.count_nonzero(seen.start)
    most = FARTHEST * plane.slope * seen.radius * math.sqrt(max(grew, 1.0))
    apart = min(max(top.value - own, -most), most)
    return apart, bool(grew < WHOLE and abs(more - own) < max(CLEAR * abs(apart), 0.5 * seen.beside))


def _off(pixels: int, noise: NoiseSpectrum) -> float:
    """Return the standard deviation, m, of the mean of so many pixels."""
    return math.sqrt(noise.of_mean(pixels) + noise.white_sd**2 / pixels)


def _slope_sd(plane: _Plane, pixels: int, noise: NoiseSpectrum) -> float:
    """Return the standard deviation of a slope along an axis, from so many pixels."""
    return SMOOTH * _off(pixels, noise) / plane.size


@dataclass(frozen=True, slots=True)
class _Seen:
    """Means of heights (h, w), m, of a part of an image, of every second, third ... row and column, and the contact in it.

    `places` (h, w) are the numbers of their pixels, `beside`, m, is how far a mean lies off the plane it is in, at most,
    and `radius`, m, is the contact's radius.
    """

    x: Image
    y: Image
    mean: Image
    seen: MaskArray
    start: MaskArray
    places: Places
    every: int
    wide: int
    beside: float
    radius: float


def _seen(points: FloatArray, valid: MaskArray, touching: MaskArray, noise: NoiseSpectrum) -> _Seen:
    """Return the means around pixels in contact (h, w)."""
    import cv2

    left, top, across, down = cv2.boundingRect(touching.view(np.uint8))
    side = math.sqrt(np.count_nonzero(touching))
    alike = LENGTHS * math.sqrt(noise.area) if noise.area > 1.5 else 0.0
    wide = max(int(min(alike, SHARE * side)) | 1, LEAST_WIDE)
    more = int(AROUND * side) + 2 * wide
    box = tuple(slice(max(first - more, 0), first + size + more) for first, size in ((top, down), (left, across)))
    cloud, here = points[box], valid[box]
    here = here & np.isfinite(cloud[..., 2])
    share = cv2.blur(here.astype(np.float32), (wide, wide))
    z = np.where(here, cloud[..., 2], 0.0).astype(np.float32)
    middle = medians(z, here, MEDIAN)
    wild = np.abs(z - middle) > WILD * math.sqrt(noise.variance)
    z = np.where(here, np.where(wild, middle, z), np.float32(0))
    mean = cv2.blur(z, (wide, wide)) / np.maximum(share, np.float32(0.5))
    every = -(-max(here.shape) // MOST_SIDE)
    some = np.s_[::every, ::every]
    x, y = (np.where(here[some], cloud[..., k][some], 0.0).astype(np.float32) for k in range(2))
    rows, columns = np.arange(here.shape[0])[:, None] + box[0].start, np.arange(here.shape[1]) + box[1].start
    one = math.sqrt(noise.of_mean(wide**2) + noise.white_sd**2 / wide**2)
    start = touching[box]
    return _Seen(
        x,
        y,
        np.asarray(mean[some], dtype=np.float32),
        np.asarray(share[some] > least_seen(share, SEEN)) & here[some],
        start[some],
        rows[::every] * valid.shape[1] + columns[::every],
        every,
        wide,
        max(BESIDE * one, LEAST_BESIDE),
        radius_of(cloud, start & here),
    )


def radius_of(cloud: FloatArray, there: MaskArray) -> float:
    """Return the radius, m, of a disc as large as the area of points (h, w, 3), m, in a mask."""
    import cv2

    count = np.count_nonzero(there)
    if not count:
        return 0.0
    wide, high = (float(np.ptp(cloud[..., k][there].astype(np.float32))) for k in range(2))
    _, _, across, down = cv2.boundingRect(there.view(np.uint8))
    return math.sqrt(wide * high / max((down - 1) * (across - 1), 1) * count / math.pi)


def _grown(seen: _Seen) -> tuple[MaskArray, _Plane, bool] | None:
    """Return the means in the plane of the contact that hang together with it, that plane, and whether it has settled; None if there is none."""
    mask, done = seen.start, False
    for _ in range(ROUNDS):
        plane = _plane(seen, mask, MOST)
        found = None if plane is None else _near(seen, plane, mask, seen.beside, GROWTH)
        if plane is None or found is None:
            return None
        before, mask = mask, found
        done = bool(np.count_nonzero(found ^ before) < SAME * np.count_nonzero(found))
        if done:
            break
    whole = plane if np.count_nonzero(before) <= MOST else _plane(seen, before)
    return None if whole is None else (mask, whole, done)


def _inner(seen: _Seen, mask: MaskArray) -> npt.NDArray[np.intp]:
    """Return the numbers (n,) of the means of a mask (h, w) that its rim does not reach, or of all where that leaves too few."""
    import cv2

    wide = -(-seen.wide // seen.every) | 1
    inner = cv2.erode(closed(mask, HOLE).view(np.uint8), np.ones((wide, wide), np.uint8)).astype(bool) & seen.seen
    at = np.flatnonzero(inner)
    return at if at.size >= LEAST else np.flatnonzero(mask & seen.seen)


def _plane(seen: _Seen, mask: MaskArray, most: int | None = None) -> _Plane | None:
    """Return the plane through the means of a mask (h, w), or through so many of them at most."""
    at = _inner(seen, mask)
    if at.size < LEAST:
        return None
    at = at[:: -(-at.size // (most or at.size))]
    x, y, z = (image.reshape(-1)[at].astype(np.float64) for image in (seen.x, seen.y, seen.mean))
    x0, y0, z0 = float(x.mean()), float(y.mean()), float(z.mean())
    x, y = x - x0, y - y0
    try:
        q, _ = settled(np.stack([np.ones_like(x), x, y]), z - z0)
    except IllConditioned:
        return None
    return _Plane(float(q[0]) + z0, float(q[1]), float(q[2]), x0, y0, math.sqrt(float(x @ x + y @ y) / 2.0 / x.size))


def _near(seen: _Seen, plane: _Plane, mask: MaskArray, beside: float, growth: int) -> MaskArray | None:
    """Return what lies within a bound, m, of a plane and hangs together with most of a mask, and grows by so many means at most, 0 for any."""
    import cv2

    close = seen.seen & (np.abs(seen.mean - plane.at(seen.x, seen.y)) < beside)
    if growth:
        kernel = np.ones((2 * growth + 1, 2 * growth + 1), np.uint8)
        close &= cv2.dilate(mask.astype(np.uint8), kernel).astype(bool)
    _, parts = cv2.connectedComponents(close.astype(np.uint8))
    held = np.asarray(parts)[mask & close]
    return np.asarray(parts == int(np.bincount(held).argmax())) if held.size else None


def _is_bent(points: FloatArray, seen: _Seen, mask: MaskArray, slope: float, noise: NoiseSpectrum) -> bool:
    """Whether the surface over a mask is clearly curved in any way, so that the side of a round top or a skirt was taken for a plane.

    Where noise is low, the rim of a face shows as a bend, too: one that is slight beside the rise of the face is no round top.
    """
    places = seen.places.reshape(-1)[_inner(seen, mask)]
    cloud = points.reshape(-1, 3)[places].astype(np.float64).T
    step = step_of(cloud[2], points[..., 2].ravel())  # all of a face may lie in one count
    of_mask = Points(np.ascontiguousarray(cloud), places, points.shape[1], noise, seen.every, step)
    top = Top(of_mask, cloud[:2].mean(axis=1), even=False)
    bend = top.q[3:]
    return bool(
        np.abs(bend).max() > SLIGHT * slope * top.size and bend @ np.linalg.solve(top.covariance[3:, 3:], bend) > BENT
    )
