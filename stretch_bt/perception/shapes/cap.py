"""The sphere under a contact: body and membrane are explained together, and by the noise that they leave."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind
from stretch_bt.errors import IllConditioned
from stretch_bt.perception.regions import Box, bounds
from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.shapes.ball import check_ball
from stretch_bt.perception.shapes.blocks_kernel import fill_within
from stretch_bt.perception.shapes.contact_cells import Cells, Window, cells_of, window_of
from stretch_bt.perception.shapes.contact_fit import BodyFit, fit_bodies, starts, starts_around
from stretch_bt.perception.shapes.contact_noise import NoiseParts, noise_left, whitener
from stretch_bt.perception.shapes.pressed_surface import COMMON, CONE, FACE, LENGTH, SPHERE, PressedSurface
from stretch_bt.perception.shapes.sphere import center_of
from stretch_bt.perception.types import MADE, Contact, MaskArray, Sphere

__all__ = ["fit_contact_sphere"]

Array = npt.NDArray[np.float64]

STARTS, FEW_STARTS = {SPHERE: 4, FACE: 3, CONE: 1}, {SPHERE: 3, FACE: 2, CONE: 1}  # under smooth noise, and under white
LEAST_OWN = 0.1  # least error of a cell by itself, over the standard deviation of a pixel: neither shape nor covariance are exact
SEARCHED, SEARCH_STEPS = (
    0.25,
    6,
)  # error of each cell by itself, over the standard deviation of a pixel, while a fit is searched; and steps then
# Error of the model of the membrane, over the curvature times the squared sine of the cap: of one pulled alike, and of one pulled along
# j, whose tensions change over a steep skirt. Sheets of the finite-strain solver and of revolution, without noise.
MODEL, MODEL_PULLED = 0.006, 0.025
# Its error over the curvature, for a sheet that bends: BENDING for any, and NARROW (LENGTH / rim)^4 for a rim hardly wider than the bend.
# Sheets of 2 mm without noise over balls of 5 to 40 mm, 1 to 14 mm deep, stretched by 0 to 60 mm.
BENDING, NARROW = 0.0035, 0.7
OUTLYING = 6.0  # standard deviations beyond which a cell holds something else than the membrane
FIRST_STEPS, FIRST_CLOSE = 8, 1.0  # most steps, and gain at the end, of a fit that is good enough to show the noise
STEPS, CLOSE = 12, 0.02
ALIKE = (
    1.3  # factor on deviations where all noise is smooth: they depend on how far it reaches, which is known to a tenth
)
TEMPER = 1.5  # nats of evidence that count as one: neither noise nor skirt are exact
SIGNIFICANCE, SIGNIFICANCE_ALIKE = (
    5.0,
    7.0,
)  # a curvature below this many standard deviations carries no radius; where all noise is smooth
FLATTEST = 0.06  # rad between the middle of a cap and its rim, below which it is as flat as the skirt is known
THINNED, BESIDE = (
    3,
    12.0,
)  # of how many cells one is searched with; nats below the best of a kind that its second may have there
NEAR = 0.4  # difference in the logarithm of a rim's size within which a start is the same
SMALL, WIDER = (
    0.35,
    2.8,
)  # share of the window's size below which a rim is small in it; size of the new window then, in rims
MISFIT = 2.0  # times the noise's variance, beyond which a contact is no such shape
MOST_SIDE = 200  # pixels, of the middle of a window, which show its noise to a hundredth


@dataclass(frozen=True, slots=True)
class _Explained:
    """All fits of a contact, and the cells they are of.

    `scale` is the residual variance of the best over their `noise`, at least 1, `wider` the factor on deviations.
    """

    fits: list[BodyFit]
    cells: Cells
    scale: float
    wider: float
    noise: NoiseParts

    def best(self, kind: int) -> float:
        """Return the best evidence of a kind, in nats."""
        return max((f.evidence for f in self.fits if f.surface.kind == kind), default=-math.inf) / self.scale

    def weights(self, kinds: tuple[int, ...]) -> tuple[list[BodyFit], Array]:
        """Return the different fits of some kinds and their probabilities."""
        ranked = sorted((f for f in self.fits if f.surface.kind in kinds), key=lambda f: -f.evidence)
        kept = [f for i, f in enumerate(ranked) if not any(f.surface.like(g.surface) for g in ranked[:i])]
        nats = np.array([f.evidence for f in kept]) / (TEMPER * self.scale)
        weights = np.exp(nats - nats.max())
        return kept, weights / weights.sum()


def fit_contact_sphere(contact: Contact) -> Sphere:
    """Fit a sphere to the surface around a contact: the sphere with the membrane that leaves it, where it leaves it.

    The segmentation only says that there is a contact. Where the membrane leaves the body is unknown, and counted in.

    Raises
    ------
    IllConditioned
        The surface is concave or shows no curvature beyond its standard deviation (flat faces show none), a cone explains it as
        well, or nothing round does; or it may be an ellipsoid, a lying cylinder or a face. One that is a little uneven has a wider deviation.
    """
    check_kind("contact", contact, Contact, MADE)
    explained = _explain(_compiled(contact))
    _check_shape(explained)
    fits, weights = explained.weights((SPHERE, FACE))
    curvatures = np.array([f.surface.q[3] for f in fits])
    mean = float(weights @ curvatures)
    spreads = (
        np.array([f.covariance[3, 3] for f in fits]) * explained.scale * explained.wider**2 + (curvatures - mean) ** 2
    )
    sd = math.hypot(math.sqrt(float(weights @ spreads)), mean * _model_error(fits[0].surface, explained.cells.size))
    if (
        mean < (SIGNIFICANCE if explained.wider == 1.0 else SIGNIFICANCE_ALIKE) * sd
        or mean * fits[0].surface.rim < FLATTEST
    ):
        raise IllConditioned(
            f"the cap carries no radius: its curvature, {mean / explained.cells.size:.3g} 1/m, has a standard deviation of"
            f" {sd / explained.cells.size:.2g} 1/m; press deeper, average more frames, or measure a flat face (`measure_contact`)"
        )
    ball = next(f for f in fits if f.surface.kind == SPHERE)
    uneven = check_ball(ball, explained.cells, explained.noise, LEAST_OWN)
    return _sphere(ball, mean, math.hypot(sd, mean * uneven), explained)


def _compiled(contact: Contact) -> Contact:
    """Return a contact whose surface compiled code takes: of another precision or byte order, or not to be written to, it is copied."""
    surface = contact.surface
    kind = np.float64 if surface.dtype.itemsize > 4 else np.float32
    fit = np.require(surface, kind, "W")
    return contact if fit is surface else replace(contact, surface=fit)


def _model_error(surface: PressedSurface, size: float) -> float:
    """Return the standard deviation, over the curvature, that the model of the membrane adds to it; its unit of length is `size`, m."""
    steep = min(abs(float(surface.q[3])) * surface.rim, 1.0)
    pulled = steep**2 * math.hypot(MODEL, MODEL_PULLED * min(abs(float(surface.q[8])), 1.0))
    return math.hypot(pulled, BENDING, NARROW * (LENGTH[0] / (surface.rim * size)) ** 4)


def _check_shape(explained: _Explained) -> None:
    if explained.best(SPHERE) == -math.inf:
        raise IllConditioned(
            "the surface is concave where the contact should be: nothing round is pressed into it; look whether the hand stands over"
            " the object, and press deeper"
        )
    if explained.scale > MISFIT:
        raise IllConditioned(
            f"neither a sphere nor a flat face explains the contact: the best leaves {math.sqrt(explained.scale):.1f} times the noise;"
            " fit another shape (`fit_shape`), or press one object at a time"
        )
    if explained.best(SPHERE) < explained.best(CONE):
        raise IllConditioned(
            "a cone explains the contact better than a sphere does, so that it has no certain radius; press deeper, or average more"
            " frames"
        )


def _explain(contact: Contact) -> _Explained:
    """Fit all bodies, at first with noise as the contact states it, then as the best of them leaves it."""
    window, cells, rough = _rough(contact, window_of(contact.surface))
    if rough and (small := max(rough, key=lambda f: f.evidence).surface).rim < SMALL:
        around = window.around(float(small.q[6]), float(small.q[7]), WIDER * small.rim)
        window, cells, rough = _rough(contact, around)
    if not rough:
        return _Explained([], cells, 1.0, 1.0, NoiseParts(contact.noise**2))
    best = max(rough, key=lambda f: f.evidence)
    noise = noise_left(_residuals(contact, best.surface, window, cells), (1e-6 * window.size) ** 2)
    noise = noise.seen_by(cells)
    fits = _searched(rough, _thinned(cells), noise)
    whiten = whitener(noise.own(cells, LEAST_OWN), noise.shared(cells) if noise.smooth else None)
    fits = fit_bodies([f.surface for f in fits], cells, whiten, steps=STEPS, close=CLOSE)
    freedom = max(cells.z.size - COMMON, 1)
    alike = noise.white / float(np.median(cells.count)) < LEAST_OWN**2 * noise.variance
    return _Explained(fits, cells, max(1.0, min(f.misfit for f in fits) / freedom), ALIKE if alike else 1.0, noise)


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
    return kept


def _near(one: PressedSurface, other: PressedSurface) -> bool:
    return one.kind == other.kind and abs(math.log(one.rim / other.rim)) < NEAR


def _rough(contact: Contact, window: Window) -> tuple[Window, Cells, list[BodyFit]]:
    """Return a window, its cells without outlying ones, and first fits of a sphere and a face, with noise as the contact states it."""
    cells = cells_of(contact, window)
    stated = max(contact.noise**2 * max(contact.noise_area, 1.0), (1e-6 * window.size) ** 2)
    whiten = whitener(NoiseParts(stated).own(cells, 0.0))
    few = _thinned(cells)
    begun = [
        s for kind in (SPHERE, FACE) for s in starts(few, window, kind, whitener(NoiseParts(stated).own(few, 0.0)))
    ]
    fits = fit_bodies(begun, cells, whiten, steps=FIRST_STEPS, close=FIRST_CLOSE)
    if not fits:
        return window, cells, fits
    errors = np.abs(whiten(max(fits, key=lambda f: f.evidence).residuals))
    return window, cells.some(errors < OUTLYING * max(1.0, MAD_TO_SD * quantile(errors))), fits


def _residuals(contact: Contact, surface: PressedSurface, window: Window, cells: Cells) -> Array:
    """Return the residuals of the pixels of the window, or of the middle of a large one, to a surface, m, NaN outside."""
    inside = np.empty(contact.surface.shape[:2], dtype=bool)
    fill_within(contact.surface, window.x, window.y, window.a, window.b, inside)
    box = _seen_box(inside)
    within = inside[box]
    x, y, z = np.ascontiguousarray(((contact.surface[box][within] - cells.origin) / cells.size).T.astype(np.float64))
    left = np.full(within.shape, np.nan)
    left[within] = (z - surface.heights(x, y)) * cells.size
    return left


def _seen_box(inside: MaskArray) -> Box:
    """Return the box around a mask, or its middle, MOST_SIDE along a side, where most of that is in the mask: enough to see noise in."""
    box = bounds(inside, 0)
    middle = _middle(box[0]), _middle(box[1])
    return middle if 2 * np.count_nonzero(inside[middle]) > inside[middle].size else box


def _middle(line: slice) -> slice:
    first = line.start + max(line.stop - line.start - MOST_SIDE, 0) // 2
    return slice(first, min(first + MOST_SIDE, line.stop))


def _sphere(fit: BodyFit, k: float, sd: float, explained: _Explained) -> Sphere:
    """Return a sphere of a curvature, in units of the cells' size, with the top that a fit has."""
    cells = explained.cells
    center, by_parameters = center_of(np.array([*fit.surface.q[:3], k]))
    covariance = fit.covariance[:4, :4] * explained.scale * explained.wider**2
    shrunk = min(sd / math.sqrt(max(float(covariance[3, 3]), 1e-300)), 1.0)
    covariance[3] *= shrunk  # a curvature that is surer than the fit's moves the top by less, too
    covariance[:, 3] *= shrunk
    covariance[3, 3] = sd**2
    spread = np.sqrt(np.einsum("ij,jk,ik->i", by_parameters, covariance, by_parameters).clip(0.0))
    return Sphere(
        radius=cells.size / k,
        radius_sd=cells.size * sd / k**2,
        center=cells.origin + cells.size * center,
        center_sd=cells.size * spread,
        curvature=k / cells.size,
        curvature_sd=sd / cells.size,
    )
