"""Means of pixels over a contact and the skirt around it, as a fit of both takes them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.blocks_kernel import blocks_within, fill_within, squares_of
from stretch_bt.perception.shapes.sight import camera_of
from stretch_bt.perception.types import Contact, FloatArray, MaskArray

__all__ = ["Cells", "Window", "cells_of", "window_of"]

Array = npt.NDArray[np.float64]

COARSE = 7  # pixels a side, in which the window is looked for
SEEN = 0.4  # share of such a square that must be valid
LOW, TOP = 0.5, 0.8  # shares of the way up from the lowest to the highest: above them are the window, and its middle
BASE = 0.05  # quantile of the heights seen, that counts as the lowest
INNER, INNER_CELLS, OUTER_CELLS = (
    0.5,
    220,
    230,
)  # reach of the finer cells, of the window's; and how many there are of each
LEAST = 60
ENOUGH = 80  # pixels, all seen, in a window of any place and form, that give so many cells


@dataclass(frozen=True, slots=True)
class Window:
    """An ellipse with middle (x, y) and semi-axes a and b, m, and the middle of its highest part; `pitch` of a pixel, m."""

    x: float
    y: float
    a: float
    b: float
    top: tuple[float, float]
    pitch: float

    @property
    def size(self) -> float:
        """Mean radius, m: the unit of length in it."""
        return math.sqrt(self.a * self.b)

    def around(self, x: float, y: float, share: float) -> Window:
        """Return a smaller window of the same form about a place, in units of the size from the middle."""
        middle = self.x + x * self.size, self.y + y * self.size
        return Window(*middle, share * self.a, share * self.b, middle, self.pitch)


@dataclass(frozen=True, slots=True)
class Cells:
    """Means (n,) of pixels: `x`, `y`, `z` from `origin` (3,), m, in units of `size`, m, with `count` pixels in each.

    `lean` (2, n) is how far a cell's ray moves x and y for every z; `u` and `v` are its column and row, in pixels; `relative_noise` is the
    standard deviation of a pixel there over its mean.
    """

    x: Array
    y: Array
    z: Array
    lean: Array
    u: Array
    v: Array
    count: Array
    origin: Array
    size: float
    relative_noise: Array

    def some(self, kept: npt.NDArray[np.bool_]) -> Cells:
        """Return those cells that are kept."""
        each = (self.x, self.y, self.z, self.lean, self.u, self.v, self.count, self.relative_noise)
        x, y, z, lean, u, v, count, relative = (a[..., kept] for a in each)
        return Cells(x, y, z, lean, u, v, count, self.origin, self.size, relative)


def cells_of(contact: Contact, window: Window) -> Cells:
    """Return the cells in a window, finer in its inner half.

    Raises IllConditioned where it has too few pixels, or too little of it is seen.
    """
    reach = (window.x, window.y, INNER * window.a, INNER * window.b)
    inner = np.asarray(blocks_within(contact.surface, *reach, INNER_CELLS))
    outer = np.asarray(blocks_within(contact.surface, window.x, window.y, window.a, window.b, OUTER_CELLS))
    if len(inner) + len(outer) >= LEAST:
        beside = 0.5 * math.sqrt(outer[:, 3].max()) * window.pitch / window.size if len(outer) else 0.0
        away = np.hypot((outer[:, 0] - window.x) / window.a, (outer[:, 1] - window.y) / window.b)
        blocks = np.concatenate([inner, outer[away > INNER + beside]])
        if len(blocks) >= LEAST:
            return _cells(blocks, window, contact)
    pixels = math.pi * window.a * window.b / window.pitch**2
    within = np.empty(contact.surface.shape[:2], np.bool_)
    fill_within(contact.surface, window.x, window.y, window.a, window.b, within)
    if pixels < ENOUGH and np.count_nonzero(within) >= SEEN * pixels:
        raise _too_few_pixels(round(pixels), ENOUGH)
    raise IllConditioned(
        "hardly any pixel around the contact has depth, so that its rim is not seen; keep the membrane in view and free of reflections"
    )


def _too_few_pixels(given: int, needed: int) -> IllConditioned:
    what = f"the contact with its surroundings covers {given} pixels, too few for a fit, which takes at least {needed}"
    return IllConditioned(f"{what}; press deeper, or bring the camera nearer")


def _cells(blocks: Array, window: Window, contact: Contact) -> Cells:
    origin, size = np.array([window.x, window.y, blocks[:, 2].mean()]), window.size
    every = max(1, len(contact.points) // 500)
    eye = camera_of(contact.points[::every].astype(np.float64), contact.rays[::every].astype(np.float64))
    x, y, z = np.ascontiguousarray((blocks[:, :3] - origin).T) / size
    places, lean = blocks[:, :2].T, np.zeros((2, len(blocks)))
    if eye is not None:
        lean = ((blocks[:, :2] - eye[:2]) / (blocks[:, 2:3] - eye[2])).T
        places = eye[:2, None] + lean * (origin[2] - eye[2])
    u, v = places / window.pitch
    return Cells(x, y, z, lean, u, v, blocks[:, 3], origin, size, np.ones(len(x)))


def window_of(surface: FloatArray) -> Window:
    """Return the window of a contact and its skirt, down to half their height.

    Raises IllConditioned where there are too few pixels, or hardly anything is seen.
    """
    height, seen, x, y = _coarse(surface)
    if np.count_nonzero(seen) < LEAST // 2:
        if seen.size < LEAST // 2 and np.count_nonzero(np.isfinite(surface[..., 2])) >= SEEN * surface[..., 2].size:
            raise _too_few_pixels(surface[..., 2].size, LEAST // 2 * COARSE**2)
        raise IllConditioned(
            "hardly any pixel has depth, so that no contact is seen; keep the membrane in view and free of reflections"
        )
    ranked = np.sort(height[seen])
    peak, base = float(ranked[-5:].mean()), float(ranked[int(BASE * ranked.size)])
    low, top = (_around_top(height, seen, base + share * (peak - base)) for share in (LOW, TOP))
    pitch = _pitch(x, y, seen)
    a, b = (2.0 * math.sqrt(float(w[low].var()) + (COARSE * pitch) ** 2 / 12.0) for w in (x, y))
    return Window(float(x[low].mean()), float(y[low].mean()), a, b, (float(x[top].mean()), float(y[top].mean())), pitch)


def _coarse(surface: FloatArray) -> tuple[Array, MaskArray, Array, Array]:
    """Return mean height of squares, whether they are seen, and their mean places, m."""
    means = squares_of(surface, COARSE)
    x, y, height, count = (np.ascontiguousarray(means[..., k]) for k in range(4))
    return height, count > SEEN * COARSE**2, x, y


def _around_top(height: Array, seen: MaskArray, least: float) -> MaskArray:
    """Return the connected part that is higher than `least` and holds the highest place."""
    from scipy.ndimage import label

    named, _ = label(seen & (height > least))
    return np.asarray(named == named[np.unravel_index(np.argmax(np.where(seen, height, -np.inf)), height.shape)])


def _pitch(x: Array, y: Array, seen: MaskArray) -> float:
    """Return the distance of neighbouring pixels, m."""
    aside, below = seen[:, 1:] & seen[:, :-1], seen[1:] & seen[:-1]
    steps = np.concatenate([np.abs(np.diff(x, axis=1))[aside], np.abs(np.diff(y, axis=0))[below]])
    return max(float(np.median(steps)) / COARSE if steps.size else 0.0, 1e-6)
