"""The size of a contact from one frame."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind
from stretch_bt.errors import IllConditioned, InvalidInput, NoAnswer, shown
from stretch_bt.perception.size.cells import HeightCells, cells_of
from stretch_bt.perception.size.choose import Choice, choose
from stretch_bt.perception.size.face import check_flat, maybe_wider
from stretch_bt.perception.size.fit import Fit
from stretch_bt.perception.size.hypothesis import HYPOTHESES, Context, FittedSizes, Hypothesis, Value
from stretch_bt.perception.size.leaning import FaceBeside, face_beside
from stretch_bt.perception.size.misfit import Misfit, misfit_of
from stretch_bt.perception.size.prior import SkirtPrior, shipped_prior
from stretch_bt.perception.size.result import ContactSize, Diameters
from stretch_bt.perception.size.start import start_of
from stretch_bt.perception.tension import check_stretch
from stretch_bt.perception.types import FloatArray, LabelArray
from stretch_bt.plain_numbers import is_number

__all__ = ["diameters", "measure_contact"]

FILLET, FILLET_SD = 1e-3, 0.58e-3  # m, of the object's edge, where the caller knows no better: any from 0 to 2 mm
LEANING, LEAST_CELLS = 3e-3, 6  # m, error of a face's middle for each unit of its slope; fewest cells that show a slope
STRIP, SEEN = 6e-3, 0.7  # m around the rim, and the share of it that must be seen; until then the sd grows
BESIDE, MOST_BESIDE = 6e-3, 0.4  # m outside the rim, and the share of the contact there that is another contact
MOST_OFF = 0.5  # of a width: how far off it may be where a contact may be the high side of a face
HIGH = 0.93  # share of the depth from which a place may be another contact
#: chi2 of an outline's clearest harmonic from which it is another outline, and the scale of chi2 over which that becomes likely; 68 frames
#: of circles and rectangles reach 5, and hexagons that none of 0.3 mm hides begin at 6 (`python -m benchmarks.outline_kinds`)
OTHER, UNLIKE = 12.0, 5.0
ANY = 0.3  # share of an outline's deviation that counts where it is no clearer than noise
DOUBT = 2.0  # standard deviations of the difference from the width of an outline without a shape, beyond which a width is unsure


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
        points,
        labels,
        stretch=stretch,
        hypothesis=hypothesis,
        fillet=fillet,
        fillet_sd=fillet_sd,
        noise=noise,
        prior=prior,
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
        In the membrane frame or the camera frame; points that are not finite or labelled 255 are left out.
    labels : (h, w) uint8
        As `segment` returns them. They only say where to look.
    stretch : float, m, or None
        Stretch of the membrane, if known, with the stretch by its mounts: the skirt's prior is several times narrower with it.
    hypothesis : str
        A shape to fit, or "auto": a circle unless the evidence is clearly for another. A shape that is named is taken for granted; with
        "auto" the outline must agree with the shape, and its distance from it enters the standard deviations.
    fillet, fillet_sd : float, m
        Radius of the object's edge and its standard deviation. A frame does not show it, and 1 mm of it is up to 1.8 mm of
        the diameter.
    noise : float, m, or None
        Standard deviation of one pixel, if known; the frame may show more, never less.
    prior : SkirtPrior or None
        Prior of another sheet than the hand's own without bending stiffness.

    Raises
    ------
    NoContact
        Nothing is valid, or nothing in contact.
    IllConditioned
        The frame does not determine a size, or the outline agrees with no shape; `.reason` says why.
    InvalidInput
        A shape, type or unit is wrong.
    """
    _check(stretch, hypothesis, fillet, fillet_sd, noise)
    if prior is not None:
        check_kind("prior", prior, SkirtPrior)
    cells = cells_of(points, labels)
    context = Context(stretch, fillet, fillet_sd, prior or shipped_prior())
    names = list(HYPOTHESES) if hypothesis == "auto" else [hypothesis]
    start = start_of(cells)
    found = choose(names, cells, start, context, noise=(noise or 0.0) / 3.0)
    beside = face_beside(cells, start.top)
    found = _of_face(found, beside, names, cells, context, (noise or 0.0) / 3.0)
    shape, fit = found.shape, found.fit
    size = shape.measure(fit.q, fit.covariance)
    off_i, off_j, off_depth = beside.off(size.diameter_i[0], size.diameter_j[0], size.depth[0])
    check_whole(shape, fit, cells, size.depth[0])
    if seen_share(shape, fit.q, cells, size) < SEEN:
        raise IllConditioned(
            "too little of the contact's rim is seen: it is cut by the edge of the frame or of the membrane;"
            " move the hand over the middle of the object"
        )
    off = max(off_i, off_j)
    (x, x_sd), (y, y_sd) = size.center
    leaning = _leaning(cells)
    measured = [(_measured(s, f), p) for s, f, p in found.rivals]
    rivals = [(other, p) for other, p in measured if other is not None]
    unlike = 0.0
    if hypothesis == "auto" and shape.name != "free_form":
        unlike = unlike_width(misfit_of(shape, fit, cells), shape.name)
    if hypothesis == "auto":
        unlike = math.hypot(unlike, maybe_wider(shape, fit, cells, size.diameter_i[0]))
    if off_i > MOST_OFF * size.diameter_i[0] or off_j > MOST_OFF * size.diameter_j[0]:
        raise IllConditioned(
            "the pixels labelled as in contact seem to be the high side of a face that leans, of which the size is not seen; press deeper,"
            " average more frames, or turn the hand to the face"
        )
    if found.held_back is not None:
        free = _measured(*found.held_back)
        unlike = unlike if free is None else math.hypot(unlike, _at_odds(size, free))
    return ContactSize(
        shape.name,
        found.evidence,
        (x, y),
        (math.hypot(x_sd, leaning), math.hypot(y_sd, leaning)),
        size.diameter_i[0],
        math.hypot(unlike, off_i, _with_rivals(size.diameter_i, [(other.diameter_i, p) for other, p in rivals])),
        size.diameter_j[0],
        math.hypot(unlike, off_j, _with_rivals(size.diameter_j, [(other.diameter_j, p) for other, p in rivals])),
        size.depth[0],
        math.hypot(size.depth[1], off_depth),
        fit.noise,
        size.sides and (size.sides[0][0], size.sides[1][0]),
        size.sides and (math.hypot(unlike, off, size.sides[0][1]), math.hypot(unlike, off, size.sides[1][1])),
        size.rotation and size.rotation[0],
        size.rotation and size.rotation[1],
    )


def _of_face(
    found: Choice, beside: FaceBeside, names: Sequence[str], cells: HeightCells, context: Context, noise: float
) -> Choice:
    """Return the shapes fitted from the face that the membrane around a contact shows, where they are more like it than those found."""
    start = beside.start()
    if start is None:
        return found
    try:
        other = choose(names, cells, start, context, noise=noise)
        return min((found, other), key=lambda choice: _away(choice, beside))
    except NoAnswer:
        return found


def _away(choice: Choice, beside: FaceBeside) -> float:
    """Return how far the widths of a choice are from the face's, m."""
    size = choice.shape.measure(choice.fit.q, choice.fit.covariance)
    return math.hypot(*beside.off(size.diameter_i[0], size.diameter_j[0], size.depth[0])[:2])


def _measured(shape: Hypothesis, fit: Fit) -> FittedSizes | None:
    """Return the sizes of another shape than the chosen one; None where it has none with an error, so that it says nothing."""
    try:
        return shape.measure(fit.q, fit.covariance)
    except IllConditioned:
        return None


def _at_odds(size: FittedSizes, free: FittedSizes) -> float:
    """Return the error of a width, m, where an outline without a shape has another width, beyond `DOUBT` of both deviations.

    Where a face leans, or the membrane is unlike the priors, a shape may fit well enough, and be half as wide.
    """
    pairs = (size.diameter_i, free.diameter_i), (size.diameter_j, free.diameter_j)
    beyond = ((a - b) ** 2 - DOUBT**2 * (a_sd**2 + b_sd**2) for (a, a_sd), (b, b_sd) in pairs)
    return math.sqrt(max(0.0, *beyond))


def unlike_width(misfit: Misfit, name: str) -> float:
    """Return the error of a width, m, since the outline may have another shape.

    Raises
    ------
    IllConditioned
        It surely has.
    """
    if misfit.chi2 > OTHER:
        raise IllConditioned(
            "the contact is neither a circle, nor an ellipse along the axes, nor a rectangle: its outline lies"
            f" {1e3 * misfit.off:.1f} mm off the {name} that explains it best, outside and inside in {misfit.harmonic} places around it;"
            " name a shape (`hypothesis`) to take it for granted, or take the outline as it is (`outline_of`)"
        )
    share = ANY + (1.0 - ANY) * (1.0 - math.exp(-((misfit.chi2 / UNLIKE) ** 2)))
    return 2.0 * share * misfit.off


def _with_rivals(chosen: Value, rivals: Sequence[tuple[Value, float]]) -> float:
    """Return the standard deviation of a width when the shape may be another one."""
    value, sd = chosen
    return math.sqrt(sd**2 + sum(p * ((other - value) ** 2 + other_sd**2) for (other, other_sd), p in rivals))


def check_whole(shape: Hypothesis, fit: Fit, cells: HeightCells, depth: float) -> None:
    """Refuse a shape that leaves much of the contact outside it, or whose face, at a depth in m, is no plane.

    Raises
    ------
    IllConditioned
        There is another contact beside it, or the top is round.
    """
    # Folds of a slack sheet may be labelled as contact too, but they do not stand as high.
    high = cells.valid & (cells.touching > 0.5) & (cells.height > HIGH * depth)
    away = shape.outside(fit.q, cells.x[high], cells.y[high])
    if np.count_nonzero(away > BESIDE) > MOST_BESIDE * away.size:
        raise IllConditioned(
            "much of the contact lies outside the one shape that fits: measure separate contacts one at a time, with the"
            " labels of the others set to 255"
        )
    check_flat(shape, fit, cells)


def seen_share(shape: Hypothesis, q: npt.NDArray[np.float64], cells: HeightCells, size: FittedSizes) -> float:
    """Return the share of the strip around the rim, `STRIP` wide, that valid cells see."""
    reach = 0.75 * max(size.diameter_i[0], size.diameter_j[0]) + STRIP
    along = (
        middle[0] + np.arange(-reach, reach, pitch) for middle, pitch in zip(size.center, cells.pitches, strict=True)
    )
    x, y = (grid.ravel() for grid in np.meshgrid(*along))
    whole, seen = shape.outside(q, x, y), shape.outside(q, cells.x[cells.valid], cells.y[cells.valid])
    return _in_strip(seen) / max(_in_strip(whole), 1)


def _leaning(cells: HeightCells) -> float:
    """Return the error of the middle of a contact, m, as its high side alone bends the membrane much where it leans."""
    inside = cells.valid & (cells.touching > 0.5)
    if np.count_nonzero(inside) < LEAST_CELLS:
        return 0.0
    x, y = cells.x[inside], cells.y[inside]
    plane = np.linalg.lstsq(np.stack([x - x.mean(), y - y.mean(), np.ones_like(x)]).T, cells.height[inside])[0]
    return LEANING * math.hypot(plane[0], plane[1])


def _in_strip(outside: npt.NDArray[np.float64]) -> int:
    return int(np.count_nonzero((outside > 0.0) & (outside < STRIP)))


def _check(stretch: float | None, hypothesis: str, fillet: float, fillet_sd: float, noise: float | None) -> None:
    if not isinstance(hypothesis, str) or hypothesis not in ("auto", *HYPOTHESES):
        raise InvalidInput(f"hypothesis is 'auto' or one of {', '.join(HYPOTHESES)}, got {shown(hypothesis)[:80]}")
    check_stretch(stretch)
    for name, value in (("fillet", fillet), ("fillet_sd", fillet_sd), ("noise", 0.0 if noise is None else noise)):
        if not (is_number(value) and 0.0 <= value < 0.05):
            raise InvalidInput(f"{name} is a length in m, from 0 to 0.05, got {shown(value)}")
