"""The size of a contact from one frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.size.cells import cells_of
from stretch_bt.perception.size.choose import choose
from stretch_bt.perception.size.hypothesis import HYPOTHESES, Context
from stretch_bt.perception.size.prior import SkirtPrior, shipped_prior
from stretch_bt.perception.size.start import start_of
from stretch_bt.perception.types import FloatArray, LabelArray
from stretch_bt.units import Angle, Length

__all__ = ["ContactSize", "Diameters", "diameters", "measure_contact"]

FILLET, FILLET_SD = 1e-3, 0.1e-3  # m, of the object's edge, where the caller knows no better
WIDEST = 0.15  # m, stretch beyond which a number is taken to be in another unit


@dataclass(frozen=True, slots=True)
class Diameters:
    """Widths of an object along i and j, m, with their standard deviations."""

    i: Length
    i_sd: Length
    j: Length
    j_sd: Length


@dataclass(frozen=True, slots=True)
class ContactSize:
    """Size of the object that a contact shows, SI, each number with its standard deviation.

    `shape` is the hypothesis that was chosen, `evidence` the natural logarithm of each one's evidence over that of the
    best. `center` (x, y) is in the frame of the points. The diameters are the widths along i and j through the centre, to
    the ends of the edge fillet. `sides` (short, long) and the `rotation` of the first from i are None for round shapes.
    `depth` is the height of the face over the undeformed membrane; `noise` is that of one cell of 3 x 3 pixels.
    """

    shape: str
    evidence: dict[str, float]
    center: tuple[Length, Length]
    center_sd: tuple[Length, Length]
    diameter_i: Length
    diameter_i_sd: Length
    diameter_j: Length
    diameter_j_sd: Length
    depth: Length
    depth_sd: Length
    noise: Length
    sides: tuple[Length, Length] | None = None
    sides_sd: tuple[Length, Length] | None = None
    rotation: Angle | None = None
    rotation_sd: Angle | None = None


def diameters(
    points: FloatArray,
    labels: LabelArray,
    *,
    stretch: float | None = None,
    hypothesis: str = "auto",
    fillet: float = FILLET,
    fillet_sd: float = FILLET_SD,
    noise: float | None = None,
    prior: SkirtPrior | None = None,
) -> Diameters:
    """Return the widths of the object in contact along i and j; takes and raises what `measure_contact` does."""
    found = measure_contact(
        points, labels, stretch=stretch, hypothesis=hypothesis, fillet=fillet, fillet_sd=fillet_sd, noise=noise, prior=prior
    )
    return Diameters(found.diameter_i, found.diameter_i_sd, found.diameter_j, found.diameter_j_sd)


def measure_contact(
    points: FloatArray,
    labels: LabelArray,
    *,
    stretch: float | None = None,
    hypothesis: str = "auto",
    fillet: float = FILLET,
    fillet_sd: float = FILLET_SD,
    noise: float | None = None,
    prior: SkirtPrior | None = None,
) -> ContactSize:
    """Measure the flat-faced object that presses into the membrane, by a joint fit of its face and the skirt around it.

    Parameters
    ----------
    points : (h, w, 3) float, m
        In the membrane frame or the camera frame; what is not finite or labelled 255 is left out.
    labels : (h, w) uint8
        As `segment` returns them. They only say where to look.
    stretch : float, m, or None
        Of the membrane, if known: the skirt's prior is several times narrower with it.
    hypothesis : str
        A shape to fit, or "auto": the simplest that no other clearly beats by its evidence.
    fillet, fillet_sd : float, m
        Radius of the object's edge and its standard deviation. A frame does not show it, and 1 mm of it is up to 1.8 mm of
        the diameter.
    noise : float, m, or None
        Standard deviation of one pixel, if known; the frame may show more, never less.
    prior : SkirtPrior or None
        Of another sheet than the hand's own.

    Raises
    ------
    NoContact
        Nothing is valid, or nothing in contact.
    IllConditioned
        The frame does not determine a size; `.reason` says why.
    InvalidInput
        A shape, type or unit is wrong.
    """
    _check(stretch, hypothesis, fillet, fillet_sd, noise)
    cells = cells_of(points, labels)
    context = Context(stretch, fillet, fillet_sd, prior or shipped_prior())
    names = list(HYPOTHESES) if hypothesis == "auto" else [hypothesis]
    shape, fit, evidence = choose(names, cells, start_of(cells), context, noise=(noise or 0.0) / 3.0)
    size = shape.measure(fit.q, fit.covariance)
    (x, x_sd), (y, y_sd) = size.center
    return ContactSize(
        shape.name,
        evidence,
        (x, y),
        (x_sd, y_sd),
        *size.diameter_i,
        *size.diameter_j,
        *size.depth,
        fit.noise,
        size.sides and (size.sides[0][0], size.sides[1][0]),
        size.sides and (size.sides[0][1], size.sides[1][1]),
        size.rotation and size.rotation[0],
        size.rotation and size.rotation[1],
    )


def _check(stretch: float | None, hypothesis: str, fillet: float, fillet_sd: float, noise: float | None) -> None:
    if hypothesis != "auto" and hypothesis not in HYPOTHESES:
        raise InvalidInput(f"hypothesis is 'auto' or one of {', '.join(HYPOTHESES)}, got {hypothesis!r}")
    if stretch is not None and not 0.0 <= stretch < WIDEST:
        raise InvalidInput(f"stretch is from 0 to {WIDEST} m, got {stretch:g}")
    for name, value in (("fillet", fillet), ("fillet_sd", fillet_sd), ("noise", noise)):
        if value is not None and not 0.0 <= value < 0.05:
            raise InvalidInput(f"{name} is a length in m, from 0 to 0.05, got {value:g}")
        if value is not None and not math.isfinite(value):
            raise InvalidInput(f"{name} is finite, got {value}")
