"""Contacts that stand apart, and the surroundings of one of them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.noise_of_frame import noise_spectrum
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.robust import quantile
from stretch_bt.perception.surface import clean
from stretch_bt.perception.top import Places, Points, Top
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray, MaskArray

__all__ = ["contacts", "noise_around", "summits", "surroundings", "window_of"]

Array = npt.NDArray[np.float64]
Box = tuple[slice, slice]

GAP = 5  # pixels between two contacts; less is one that noise or a reflection cut
SHARE = 0.2  # share of the largest contact's pixels from which a part counts as a contact of its own
MOST = 4  # contacts that are looked at, the largest
LONG = 1.4  # times as long as wide, from which a contact may be two
CONCAVE = 2.5  # standard deviations of its curvature along, from which it is a saddle
LEAST_TOP = 16  # points of a top
LEAST_IN = 8  # pixels of a window along an axis of a contact
DIP, LEAST_DIP = (
    3.5,
    0.5,
)  # standard deviations, least dip of a contact, at LONG and where it is longer by LONGER: then it is hardly one
LONGER = 1.2
REACH = 2.5  # half lengths of a contact, as far as which the membrane is looked at for a place to which it rises
MEDIAN = 1.6  # variance of a median over a mean's
SEEN = 110, 160  # rows and columns to either side of the contact in which noise is measured
BESIDE = 7  # pixels from the contact found, whose rim noise may have cut off, beyond which the membrane is free
FAR = 18  # pixels from the contact at which the skirt bends little
WIDEST = 3.2  # radii of the contact, as far as which the surroundings reach
LEAST_FAR = 6.0  # lengths of noise, as far as which they reach at least
ENOUGH = 6_000  # pixels of the surroundings, of which noise that is alike leaves far more than white noise does


class HeightWindow(NamedTuple):
    """The median height of the points about a place along an axis, m, and its variance, m^2."""

    place: float
    height: float
    variance: float

    def above(self, other: HeightWindow) -> float:
        """Return by how many standard deviations it is the higher."""
        return (self.height - other.height) / math.sqrt(max(self.variance + other.variance, 1e-18))


def contacts(labels: LabelArray) -> list[Places]:
    """Return the pixels (n,) of each contact, largest first; parts that are nearly joined are one, and specks are left out."""
    import cv2

    touching = labels == CONTACT
    near = cv2.dilate(touching.view(np.uint8), np.ones((GAP, GAP), dtype=np.uint8))
    count, numbers = cv2.connectedComponents(near)
    places = np.flatnonzero(touching)
    if count <= 2:
        return [places]
    part = numbers.reshape(-1)[places]
    sizes = np.bincount(part, minlength=count)
    order = [int(k) for k in np.argsort(-sizes, kind="stable")[:MOST] if sizes[k] >= max(SHARE * sizes.max(), 1)]
    return [places[part == k] for k in order]


def summits(contact: Points, around: Points, sd: float) -> list[Points]:
    """Return the points of a contact, or of each place to which the membrane rises from its middle, where it does.

    Two bodies in a line along the tight direction of a membrane look like one, and noise lets the saddle between them look like contact.
    `sd`, m, is the standard deviation of one pixel's independent noise.
    """
    cloud = contact.cloud
    middle = np.array([quantile(cloud[0]), quantile(cloud[1])])
    beside = cloud[:2] - middle[:, None]
    spread, axes = np.linalg.eigh(beside @ beside.T / len(contact))
    short, long = (
        2.0 * math.sqrt(max(float(value), 1e-18)) for value in spread
    )  # of an ellipse, half as wide and long
    if long < LONG * short:
        return [contact]
    axis, seen = axes[:, 1], around.cloud[:2] - middle[:, None]
    t, s = axis @ seen, np.abs(axis[::-1] @ (seen * [[1.0], [-1.0]]))
    row = _windows(around, t, s, 0.5 * short, REACH * long, sd)
    clear = min(max(DIP - (DIP - LEAST_DIP) * (long / short - LONG) / LONGER, LEAST_DIP), DIP)
    tops = _tops(row, long, clear, concave=Top(contact, middle, even=False).curved_along(axis) < -CONCAVE)
    discs = [around.at(np.flatnonzero((t - top) ** 2 + s**2 < short**2)) for top in tops]
    return [disc for disc in discs if len(disc) >= LEAST_TOP] or [contact]


def _windows(around: Points, t: Array, s: Array, step: float, reach: float, sd: float) -> list[HeightWindow]:
    """Return the windows along an axis up to `reach` from 0; `t`, `s` (n,) are the points' distances along it and from it, m."""
    count = min(math.ceil(reach / step), 24)
    row = list[HeightWindow]()
    for place in step * np.arange(-count, count + 1):
        inside = np.flatnonzero((np.abs(t - place) < step) & (s < 1.5 * step))
        if inside.size >= LEAST_IN:
            shared = around.noise.of_mean(inside.size * around.every**2) if around.noise is not None else 0.0
            variance = MEDIAN * sd * sd / inside.size + shared
            row.append(HeightWindow(float(place), quantile(around.cloud[2][inside]), variance))
    return row


def _tops(row: list[HeightWindow], length: float, clear: float, *, concave: bool) -> list[float]:
    """Return to which places, m, the membrane rises from the middle of a row: on both sides of a dip, or on one; none where it does not.

    A dip counts from `clear` standard deviations, or at all where the contact is `concave`.
    """
    inner = [k for k, window in enumerate(row) if abs(window.place) <= length]
    if not inner:
        return []
    start = min(inner, key=lambda k: abs(row[k].place))
    clearest, found = 0.0 if concave else clear, list[float]()
    for k in [start] if concave else inner:
        fall = DIP * math.sqrt(row[k].variance)
        left, right = _highest(row[k::-1], fall), _highest(row[k:], fall)
        rise = min(left.above(row[k]), right.above(row[k]))
        if rise > clearest:
            clearest, found = rise, [left.place, right.place]
    if found:
        return found
    top = max((row[k] for k in inner), key=lambda window: window.height)
    return [top.place] if top.above(row[start]) > DIP else []


def _highest(side: list[HeightWindow], fall: float) -> HeightWindow:
    """Return the highest of windows on the way from the first until they fall by so much, m."""
    best = side[0]
    for window in side:
        if window.height > best.height:
            best = window
        elif window.height < best.height - fall:
            break
    return best


def window_of(places: Places, shape: tuple[int, ...], *far: int) -> tuple[Box, list[MaskArray]]:
    """Return the box of an image, around some of its pixels (n,), in which noise is measured, and for each distance where none is so near.

    Those masks are (h, w), of the box alone; the distances are pixels along both axes.
    """
    import cv2

    there = np.zeros(shape, dtype=np.uint8)
    there.reshape(-1)[places] = 1
    left, top, across, down = cv2.boundingRect(there)
    rows, columns = (
        slice(max(first - more, 0), min(first + size + more, whole))
        for first, size, more, whole in zip((top, left), (down, across), SEEN, shape, strict=True)
    )
    squares = (np.ones((2 * away + 1, 2 * away + 1), dtype=np.uint8) for away in far)
    return (rows, columns), [np.asarray(cv2.dilate(there[rows, columns], square) == 0) for square in squares]


def noise_around(points: FloatArray, valid: MaskArray, places: Places) -> NoiseSpectrum | None:
    """Return the noise of a frame around some of its pixels (n,); None where too little is seen."""
    window, (apart, free) = window_of(places, valid.shape, FAR, BESIDE)
    if not valid[window].any():
        return None
    try:
        cleaned = clean(points[window], valid[window], 1, square=False)
    except InvalidInput:
        return None
    if cleaned is None:
        return None
    return noise_spectrum(cleaned, apart[cleaned.box], free[cleaned.box])


def surroundings(points: FloatArray, valid: MaskArray, touching: Points, noise: NoiseSpectrum) -> Points:
    """Return the points around a contact, in contact or not, of every pixel, or of fewer where noise is alike over more or they are many."""
    length = math.sqrt(noise.area / (4.0 * math.pi))
    step = min(max(int(length), 1), 3)
    rows, columns = touching.places // touching.wide, touching.places % touching.wide
    middle = quantile(rows.astype(np.float64)), quantile(columns.astype(np.float64))
    radius = math.sqrt(2.0 * quantile((rows - middle[0]) ** 2.0 + (columns - middle[1]) ** 2.0))
    more = math.ceil(max(WIDEST * radius, LEAST_FAR * length))
    (top, bottom), (left, right) = (
        (max(int(m) - more, 0), min(int(m) + more + 1, n)) for m, n in zip(middle, valid.shape, strict=True)
    )
    step = max(step, math.ceil(math.sqrt((bottom - top) * (right - left) / ENOUGH)))
    v, u = np.arange(top, bottom, step), np.arange(left, right, step)
    places = (v[:, None] * valid.shape[1] + u).reshape(-1)
    places = places[valid.reshape(-1)[places]]
    cloud = np.asarray(points.reshape(-1, 3)[places].T, dtype=np.float64)
    finite = np.isfinite(cloud).all(axis=0)
    return Points(np.ascontiguousarray(cloud[:, finite]), places[finite], valid.shape[1], noise, step, touching.step)
