"""The sphere under a contact: body and membrane are explained together, and by the noise that they leave."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind
from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.ball import check_ball
from stretch_bt.perception.shapes.contact_cells import Cells
from stretch_bt.perception.shapes.contact_fit import BodyFit, fit_bodies
from stretch_bt.perception.shapes.contact_noise import NoiseParts, whitener
from stretch_bt.perception.shapes.contact_search import search
from stretch_bt.perception.shapes.pressed_surface import COMMON, CONE, FACE, LENGTH, SPHERE, PressedSurface
from stretch_bt.perception.shapes.sphere import center_of
from stretch_bt.perception.types import MADE, Contact, Sphere

__all__ = ["fit_contact_sphere"]

Array = npt.NDArray[np.float64]

LEAST_OWN = 0.1  # least error of a cell by itself, over the standard deviation of a pixel: neither shape nor covariance are exact
# Error of the model of the membrane, over the curvature times the squared sine of the cap: of one pulled alike, and of one pulled along
# j, whose tensions change over a steep skirt. Sheets of the finite-strain solver and of revolution, without noise.
MODEL, MODEL_PULLED = 0.006, 0.025
# Its error over the curvature, for a sheet that bends: BENDING for any, and NARROW (LENGTH / rim)^4 for a rim hardly wider than the bend.
# Sheets of 2 mm without noise over balls of 5 to 40 mm, 1 to 14 mm deep, stretched by 0 to 60 mm.
BENDING, NARROW = 0.0035, 0.7
STEPS, CLOSE = 12, 0.02
# Factor on deviations where all noise is smooth: they depend on how far it reaches, which is known to a tenth.
ALIKE = 1.15
TEMPER = 1.5  # nats of evidence that count as one: neither noise nor skirt are exact
CLEARER = 2.0  # nats from which a cone explains a contact clearly better than a sphere
ONE_TOP = 9.0  # chi-square of the difference of two fits below which they are one
# A curvature below so many standard deviations carries no radius; and where all noise is smooth.
SIGNIFICANCE, SIGNIFICANCE_ALIKE = 5.0, 7.0
FLATTEST = 0.06  # rad between the middle of a cap and its rim, below which it is as flat as the skirt is known
CONCAVE = (
    "the surface is concave where the contact should be: nothing round is pressed into it; look whether the hand stands over the object, and press"
    " deeper"
)
MISFIT = 2.0  # times the noise's variance, beyond which a contact is no such shape


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
        kept = list[BodyFit]()
        for fit in ranked:
            if not any(_one_top(fit, other) for other in kept):
                kept.append(fit)
        nats = np.array([f.evidence for f in kept]) / (TEMPER * self.scale)
        weights = np.exp(nats - nats.max())
        return kept, weights / weights.sum()


def fit_contact_sphere(contact: Contact) -> Sphere:
    """Fit a sphere to the surface around a contact: the sphere with the membrane that leaves it, where it leaves it.

    The segmentation only says that there is a contact. Where the membrane leaves the body is unknown, and counted in.

    Raises
    ------
    IllConditioned
        The surface is concave or shows no curvature beyond its standard deviation (flat faces show none), a cone explains it clearly
        better, or nothing round does; or it may be an ellipsoid, a lying cylinder or a face. One that is a little uneven has a wider deviation.
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


def _one_top(fit: BodyFit, better: BodyFit) -> bool:
    """Whether a fit stands within what another of its kind leaves open, so that the probability has one top for both."""
    if fit.surface.kind != better.surface.kind:
        return False
    apart = fit.surface.q - better.surface.q
    return float(apart @ np.linalg.solve(better.covariance, apart)) < ONE_TOP


def _model_error(surface: PressedSurface, size: float) -> float:
    """Return the standard deviation, over the curvature, that the model of the membrane adds to it; its unit of length is `size`, m."""
    steep = min(abs(float(surface.q[3])) * surface.rim, 1.0)
    pulled = steep**2 * math.hypot(MODEL, MODEL_PULLED * min(abs(float(surface.q[8])), 1.0))
    return math.hypot(pulled, BENDING, NARROW * (LENGTH[0] / (surface.rim * size)) ** 4)


def _check_shape(explained: _Explained) -> None:
    if explained.best(SPHERE) == -math.inf:
        raise IllConditioned(CONCAVE)
    if explained.scale > MISFIT:
        raise IllConditioned(
            f"neither a sphere nor a flat face explains the contact: the best leaves {math.sqrt(explained.scale):.1f} times the noise;"
            " fit another shape (`fit_shape`), or press one object at a time"
        )
    if explained.best(SPHERE) < explained.best(CONE) - CLEARER:
        raise IllConditioned(
            "a cone explains the contact clearly better than a sphere does, so that it has no certain radius; press deeper, or average more"
            " frames"
        )


def _explain(contact: Contact) -> _Explained:
    """Fit all bodies, at first with noise as the contact states it, then as the best of them leaves it."""
    found = search(contact)
    if found is None:
        raise IllConditioned(CONCAVE)
    cells, noise = found.cells, found.noise
    whiten = whitener(noise.own(cells, LEAST_OWN), noise.shared(cells) if noise.smooth else None)
    fits = fit_bodies([f.surface for f in found.fits], cells, whiten, steps=STEPS, close=CLOSE)
    freedom = max(cells.z.size - COMMON, 1)
    alike = noise.white / float(np.median(cells.count)) < LEAST_OWN**2 * noise.variance
    return _Explained(fits, cells, max(1.0, min(f.misfit for f in fits) / freedom), ALIKE if alike else 1.0, noise)


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
