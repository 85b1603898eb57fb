"""Where the fits of a contact begin: in a window about as wide as the body's rim, from rims of many sizes and forms."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.regions import Box, bounds
from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.shapes.blocks_kernel import fill_within
from stretch_bt.perception.shapes.contact_cells import Cells, Window, cells_of, window_of
from stretch_bt.perception.shapes.contact_fit import BodyFit, fit_bodies, starts, starts_around
from stretch_bt.perception.shapes.contact_noise import NoiseParts, Whiten, noise_left, whitener
from stretch_bt.perception.shapes.pressed_surface import CONE, FACE, SPHERE, PressedSurface
from stretch_bt.perception.shapes.uneven_noise import SIDE, relative_noise
from stretch_bt.perception.types import Contact, MaskArray

__all__ = ["Search", "search"]

Array = npt.NDArray[np.float64]

STARTS, FEW_STARTS = {SPHERE: 4, FACE: 3, CONE: 1}, {SPHERE: 3, FACE: 2, CONE: 1}  # under smooth noise, and under white
FIRST_STEPS, FIRST_CLOSE = 8, 1.0  # most steps, and gain at the end, of a fit that is good enough to show the noise
# Error of each cell by itself, over the standard deviation of a pixel, while a fit is searched; and steps then.
SEARCHED, SEARCH_STEPS = 0.25, 6
OUTLYING = 6.0  # standard deviations beyond which a cell holds something else than the membrane
# Of how many cells one is searched with; nats below the best of a kind that its second may have there.
THINNED, BESIDE = 3, 12.0
# Nats between the best sphere and the best face from which the search of the lesser may have gone astray, and how many starts the other lends it.
ASTRAY, LENT = 12.0, 2
NEAR = 0.4  # difference in the logarithm of a rim's size within which a start is the same
# Share of the window's size below which a rim is small in it; size of the new window then, in rims.
SMALL, WIDER = 0.35, 2.8
MOST_SIDE = 200  # pixels, of the middle of a window, which show its noise to a hundredth


@dataclass(frozen=True, slots=True)
class Search:
    """Fits of all bodies that are good enough to begin from, the cells they are of, and the noise that the best of them leaves."""

    cells: Cells
    noise: NoiseParts
    fits: list[BodyFit]


class _Rough(NamedTuple):
    """First fits of a sphere and a face, the window that they are of, and its cells without outlying ones."""

    window: Window
    cells: Cells
    fits: list[BodyFit]


def search(contact: Contact) -> Search | None:
    """Return where to begin, None where nothing is pressed up.

    A window much wider than the body has cells so coarse that a sphere and a face are hard to tell apart; it is narrowed.
    """
    first = _rough(contact, window_of(contact.surface))
    if not first.fits:
        return None
    rough = _narrower(contact, first, first.fits)
    found = _found(contact, rough)
    narrower = _narrower(contact, rough, found.fits)
    return found if narrower is rough else _found(contact, narrower)


def _best(fits: list[BodyFit]) -> BodyFit:
    return max(fits, key=lambda f: f.evidence)


def _narrower(contact: Contact, rough: _Rough, fits: list[BodyFit]) -> _Rough:
    """Return first fits in a window about the rim of the best of some fits, where that is small; those given where it shows nothing else."""
    small = _best(fits).surface
    if small.rim >= SMALL:
        return rough
    narrower = _rough(contact, rough.window.around(float(small.q[6]), float(small.q[7]), WIDER * small.rim))
    return narrower if narrower.fits else rough


def _found(contact: Contact, rough: _Rough) -> Search:
    window, cells, fits = rough
    points, left = _residuals(contact, _best(fits).surface, window, cells)
    floor = (1e-6 * window.size) ** 2
    noise = noise_left(left, floor)
    relative = relative_noise(left, noise.area)
    if relative is not None:
        cells = _uneven(cells, points, relative)
        noise = noise_left(left / _of_pixels(relative, left.shape), floor)
    noise = noise.seen_by(cells)
    return Search(cells, noise, _searched(fits, _thinned(cells), noise))


def _thinned(cells: Cells) -> Cells:
    """Return a part of the cells, which is enough to find where to begin."""
    return cells.some(np.arange(cells.z.size) % THINNED == 0)


def _searched(rough: list[BodyFit], cells: Cells, noise: NoiseParts) -> list[BodyFit]:
    """Return the two best fits of each kind from many starts, each cell with an error of its own that hides all that is fine.

    Without it smooth noise makes the probability so rugged that a fit ends beside its top. A second one far less probable is left out.
    """
    whiten = whitener(noise.own(cells, SEARCHED), noise.shared(cells) if noise.smooth else None)
    kept = list[BodyFit]()
    for kind, most in (STARTS if noise.smooth else FEW_STARTS).items():
        base = next((f for f in rough if f.surface.kind == kind), rough[0]).surface
        begun = starts_around(base, cells, kind, whiten, most)
        begun += [base] if base.kind == kind and not any(_near(base, s) for s in begun) else []
        fits = fit_bodies(begun, cells, whiten, steps=SEARCH_STEPS, close=FIRST_CLOSE)
        ranked = sorted(fits, key=lambda f: -f.evidence)
        for fit in (f for f in ranked if f.evidence > ranked[0].evidence - BESIDE):
            if sum(k.surface.kind == kind for k in kept) < 2 and not any(fit.surface.like(k.surface) for k in kept):
                kept.append(fit)
    return kept + fit_bodies(_lent(kept, cells, whiten), cells, whiten, steps=SEARCH_STEPS, close=FIRST_CLOSE)


def _lent(fits: list[BodyFit], cells: Cells, whiten: Whiten) -> list[PressedSurface]:
    """Return more starts for a sphere or a face that ended far from the other: rims around the other's."""
    best = {
        kind: max((f for f in fits if f.surface.kind == kind), key=lambda f: f.evidence, default=None)
        for kind in (SPHERE, FACE)
    }
    begun = list[PressedSurface]()
    for kind, other in ((SPHERE, FACE), (FACE, SPHERE)):
        own, lender = best[kind], best[other]
        if lender and (own is None or own.evidence < lender.evidence - ASTRAY):
            begun += starts_around(lender.surface, cells, kind, whiten, LENT)
    return begun


def _near(one: PressedSurface, other: PressedSurface) -> bool:
    return one.kind == other.kind and abs(math.log(one.rim / other.rim)) < NEAR


def _rough(contact: Contact, window: Window) -> _Rough:
    """Return first fits in a window, with noise as the contact states it."""
    cells = cells_of(contact, window)
    stated = max(contact.noise**2 * max(contact.noise_area, 1.0), (1e-6 * window.size) ** 2)
    whiten = whitener(NoiseParts(stated).own(cells, 0.0))
    few = _thinned(cells)
    begun = [
        s for kind in (SPHERE, FACE) for s in starts(few, window, kind, whitener(NoiseParts(stated).own(few, 0.0)))
    ]
    fits = fit_bodies(begun, cells, whiten, steps=FIRST_STEPS, close=FIRST_CLOSE)
    if not fits:
        return _Rough(window, cells, fits)
    errors = np.abs(whiten(_best(fits).residuals))
    near = errors < OUTLYING * max(1.0, MAD_TO_SD * quantile(errors))
    return _Rough(window, cells.some(near), fits)


def _of_pixels(squares: Array, shape: tuple[int, ...]) -> Array:
    """Return what squares hold for each pixel (h, w)."""
    rows, columns = (np.minimum(np.arange(n) // SIDE, m - 1) for n, m in zip(shape, squares.shape, strict=True))
    return squares[np.ix_(rows, columns)]


def _uneven(cells: Cells, points: Array, relative: Array) -> Cells:
    """Return cells with the relative noise of the square nearest to each; `points` (h, w, 2) are the places of pixels, NaN outside."""
    from scipy.spatial import KDTree

    sides = zip(points.shape[:2], relative.shape, strict=True)
    places = points[np.ix_(*(np.minimum(np.arange(m) * SIDE + SIDE // 2, n - 1) for n, m in sides))]
    known = np.isfinite(places[..., 0])
    if not known.any():
        return cells
    _, nearest = KDTree(places[known]).query(np.stack([cells.x, cells.y], axis=1))
    return replace(cells, relative_noise=relative[known][nearest])


def _residuals(contact: Contact, surface: PressedSurface, window: Window, cells: Cells) -> tuple[Array, Array]:
    """Return places (h, w, 2), in the cells' unit, and residuals (h, w), m, of the pixels of the window, or of the middle of a large one.

    NaN outside of it.
    """
    inside = np.empty(contact.surface.shape[:2], dtype=bool)
    fill_within(contact.surface, window.x, window.y, window.a, window.b, inside)
    box = _seen_box(inside)
    within = inside[box]
    x, y, z = np.ascontiguousarray(((contact.surface[box][within] - cells.origin) / cells.size).T.astype(np.float64))
    left = np.full(within.shape, np.nan)
    left[within] = (z - surface.heights(x, y)) * cells.size
    places = np.full((*within.shape, 2), np.nan)
    places[within] = np.stack([x, y], axis=1)
    return places, left


def _seen_box(inside: MaskArray) -> Box:
    """Return the box around a mask, or its middle, MOST_SIDE along a side, where most of that is in the mask: enough to see noise in."""
    box = bounds(inside, 0)
    middle = _middle(box[0]), _middle(box[1])
    return middle if 2 * np.count_nonzero(inside[middle]) > inside[middle].size else box


def _middle(line: slice) -> slice:
    first = line.start + max(line.stop - line.start - MOST_SIDE, 0) // 2
    return slice(first, min(first + MOST_SIDE, line.stop))
