"""Height of the object's top: the vertex of a quadratic on a curved top, a robust mean on a flat one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_estimates
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact, shown
from stretch_bt.perception.clean import without_flying
from stretch_bt.perception.high_part import HighMeans
from stretch_bt.perception.leaning import lean_of
from stretch_bt.perception.leaning_face import face_of
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.pitch import pitch_of
from stretch_bt.perception.robust import quantile, sample
from stretch_bt.perception.steps import shared_step, step_of
from stretch_bt.perception.stripes import NO_STRIPES
from stretch_bt.perception.surface import check_array, check_labels, check_points, finite
from stretch_bt.perception.top import Places, Points, Top, disc_of, settled
from stretch_bt.perception.tops import contacts, noise_around, summits, surroundings
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray, MaskArray
from stretch_bt.perception.wide_top import by_wide_discs
from stretch_bt.units import Estimate, is_number

__all__ = ["top_of_pixels", "top_of_points", "track_height", "within_reach"]

Array = npt.NDArray[np.float64]

RIM = 0.75  # share of the contact's radius that the membrane's bend at the rim leaves alone
HIGH = 0.1  # share of the points that are the highest
AROUND = 1.5  # radii of those within which a top is sought
BEND = 0.35  # share of the radius of curvature within which a quadratic is a sphere to a thousandth of the radius
SAG = 0.15  # of the depth; standard deviation of how far a round top falls within RIM, over presses of spheres of 5 to 60 mm
ROUGHLY = 0.4  # of the curvature by a disc that may hold skirt: its standard deviation
LEAST_POINTS = 12
MOST_CURVED = 1e10  # 1/m, of an atom
PARTS = 2  # high parts of a contact that are tried

MOST = 20_000  # points, whose height is known to far less than a camera's count, and not better by more
RUN = 64  # neighbours that are kept together, since they show how far noise is alike
UNSEEN = (
    "no pixel in contact has depth, so that the top is not seen; press deeper, or keep reflections off the membrane"
)


class _Top(NamedTuple):
    """Height of a top, m, and whether it is clearly curved."""

    height: Estimate
    is_curved: bool


def track_height(
    points: FloatArray,
    valid: MaskArray,
    labels: LabelArray,
    *,
    curvature: Estimate | None = None,
    reach: float | None = None,
) -> Estimate:
    """Return the height of the object's top, z of the membrane frame, m; with several separate contacts, the height of the highest.

    The vertex of a free quadratic over a disc has four times the variance of the mean; where the curvature of a round top is known, it
    and the mean give the height. Where noise is alike over much of a contact, wider discs give it, with the membrane around the contact.

    Parameters
    ----------
    points : (h, w, 3) float, m, membrane frame
    valid : (h, w) bool
    labels : (h, w) uint8
        Classes as `segment` gives them, of this frame or of an earlier one with the same contact.
    curvature
        Curvature of the top, 1/m, where it is known from elsewhere; ignored where the points differ from it by three standard deviations.
    reach : float, m
        Largest height or depth that the membrane can have (`HandGeometry.reach`), where it is known.

    Returns
    -------
    Estimate
        Its standard deviation includes noise that is alike over up to some ten pixels, or five wider than 0.55 mm, as the frame itself
        shows it, and the steps in which heights come, as far as the noise does not even them out. A camera's error that all of the
        contact shares is not in it.

    Raises
    ------
    NoContact
        No valid pixel is in contact.
    IllConditioned
        Too few pixels for a height with its error, or the height is one that no membrane reaches.
    """
    check_points(points, valid)
    check_labels(labels, points)
    if curvature is not None:
        check_curvature(curvature)
    if reach is not None and not (is_number(reach) and reach > 0):
        raise InvalidInput(f"reach is a length above 0 m, got {shown(reach)}")
    valid = finite(points, valid)
    if not valid.any():
        raise NoContact(UNSEEN)
    valid = without_flying(points, valid, pitch_of(points, valid))
    found = [places[valid.reshape(-1)[places]] for places in contacts(labels)]
    found = [places for places in found if places.size >= LEAST_POINTS] or found[:1]
    if not found or not found[0].size:
        raise NoContact(UNSEEN)
    noise = noise_around(points, valid, np.concatenate(found))
    others = sample(points[..., 2], valid)
    tops, refusals = list[_Top](), list[IllConditioned]()
    for places in found:
        try:
            tops += _tops(points, valid, _some(places), noise, others, curvature)
        except IllConditioned as refusal:
            refusals.append(refusal)
    if not tops:
        raise refusals[0]
    return within_reach(_highest(points, valid, labels == CONTACT, noise, others, curvature, tops), reach)


def check_curvature(curvature: Estimate) -> None:
    """Raise InvalidInput unless a curvature, 1/m, is known with a standard deviation above 0."""
    check_estimates(curvature=curvature)
    if curvature.sd == 0:
        raise InvalidInput(f"curvature must be finite, 1/m, with a standard deviation above 0, not {curvature}")
    if max(abs(curvature.value), curvature.sd) > MOST_CURVED:
        raise InvalidInput(
            f"curvature is in 1/m, and no surface is bent by more than {MOST_CURVED:g}, not {curvature}; give one over the radius in m"
        )


def _highest(
    points: FloatArray,
    valid: MaskArray,
    touching: MaskArray,
    noise: NoiseSpectrum | None,
    others: FloatArray,
    curvature: Estimate | None,
    tops: list[_Top],
) -> Estimate:
    """Return the height, m, of the highest top, or of a part of all pixels in contact (h, w) that stands clearly higher, or of a face that leans."""
    if noise is None:
        return max((top.height for top in tops), key=lambda height: height.value)
    highest, curved = max(tops, key=lambda top: top.height.value), any(top.is_curved for top in tops)
    lean = lean_of(points, valid, touching, noise, highest.height)
    if lean.height is not None:
        return lean.height
    face = face_of(points, valid, touching, noise, highest.height, lean.slope, flat=len(tops) == 1 and not curved)
    if face.height is not None:
        return face.height
    top = _highest_part(points, valid, touching, noise, others, curvature, tops)
    alone = len(tops) == 1 and top == tops[0].height  # a higher part, or two bodies, make a plane that is no face's
    return face.of(top if curved or (lean.is_hidden and not alone) else lean.of(top))


def _highest_part(
    points: FloatArray,
    valid: MaskArray,
    touching: MaskArray,
    noise: NoiseSpectrum,
    others: FloatArray,
    curvature: Estimate | None,
    tops: list[_Top],
) -> Estimate:
    """Return the height, m, of the highest top, or of a part of all pixels in contact (h, w) that stands clearly higher."""
    means = HighMeans.of(points, valid, touching)
    for left in range(PARTS, -1, -1):
        top = max((top.height for top in tops), key=lambda height: height.value)
        part = means.above(noise, top)
        if part is None:
            break
        if left == 0 or not part.is_enough:
            return part.height
        tops = list(_tops(points, valid, _some(part.places), noise, others, curvature))
    return top


def _tops(
    points: FloatArray,
    valid: MaskArray,
    places: Places,
    noise: NoiseSpectrum | None,
    others: FloatArray,
    curvature: Estimate | None,
) -> Iterator[_Top]:
    """Yield the tops of the contact at some pixels (n,): of one, or of two that look like a long one."""
    touching = _points(points.reshape(-1, 3)[places], places, valid.shape[1], noise)
    step = step_of(touching.cloud[2], others)
    noise = None if noise is None else noise.beside_counts(step)
    touching = replace(touching, step=step, noise=noise)
    if noise is None:
        yield _best(touching, curvature)
        return
    around = surroundings(points, valid, touching, noise)
    for part in summits(touching, around, max(noise.white_sd, touching.step / math.sqrt(12.0))):
        top = _best(part, curvature)
        alone = noise.area <= 1.0 and noise.stripes == NO_STRIPES
        yield top if alone else _Top(by_wide_discs(top.height, part, around), top.is_curved)


def top_of_points(points: FloatArray) -> Estimate:
    """Return the height, m, of the top of contact points (n, 3), m, membrane frame; raises as `track_height`.

    Its standard deviation assumes noise that is independent from point to point.
    """
    check_array("points", points)
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu":
        raise InvalidInput(f"contact points are real numbers of shape (n, 3), m, got {points.dtype} {points.shape}")
    return top_of_pixels(points, np.arange(len(points)), 1, None)


def top_of_pixels(
    points: FloatArray, places: Places, wide: int, noise: NoiseSpectrum | None, by_half: float = 1.0
) -> Estimate:
    """Do as `top_of_points` with points (n, 3), m, of the pixels (n,) of an image `wide` pixels wide, and its noise where that is known.

    Its standard deviation includes `by_half` times the difference from the height of a disc half as wide.
    """
    some = _some(np.arange(len(points)))
    seen = _points(points[some], places[some], wide, noise)
    return _best(replace(seen, step=step_of(seen.cloud[2], seen.cloud[2])), by_half=by_half).height


def within_reach(height: Estimate, reach: float | None) -> Estimate:
    """Return a height, m, that a membrane with a reach, m, can have; raises IllConditioned for any other."""
    if reach is not None and abs(height.value) > reach:
        raise IllConditioned(
            f"the top would stand {height.value:.3g} m out of the plane of the flat membrane, which this hand's membrane cannot: at most"
            f" {reach:.3g} m; look where the camera points, and at `plane_distance`, `gauge` and the size of the membrane in the cell"
        )
    return height


def _some(places: Places) -> Places:
    """Return at most MOST of numbers (n,), in runs spread evenly over them."""
    every = -(-places.size // MOST)
    return places if every <= 1 else places[np.arange(places.size) // RUN % every == 0]


def _points(points: FloatArray, places: Places, wide: int, noise: NoiseSpectrum | None) -> Points:
    """Return the finite ones of points (n, 3), m; too few for a height are refused."""
    cloud = np.asarray(points, dtype=np.float64)
    found = Points(np.ascontiguousarray(cloud.T), places, wide, noise)
    finite = np.isfinite(found.cloud).all(axis=0)
    if not finite.all():
        found = found.at(np.flatnonzero(finite))
    if not len(found):
        raise NoContact(UNSEEN)
    if len(found) < LEAST_POINTS:
        raise IllConditioned(
            f"a height with its error needs at least twelve points in contact, there are {len(found)}; press deeper, or average frames"
        )
    return found


def _best(points: Points, known: Estimate | None = None, by_half: float = 1.0) -> _Top:
    """Return the top from a disc that the membrane's bend at the rim leaves alone."""
    cloud = points.cloud
    middle, away, radius = disc_of(cloud)
    reach = RIM * radius
    near = _disc(points, away, reach)
    top = Top(near, middle, even=False).bent(known)
    if not top.is_curved:
        top, reach = _of_highest(points, top, reach, known)
    if top.is_curved:
        within = min(reach, max(BEND / top.curvature, 0.3 * radius))
        middle = top.vertex(radius)
        before, near, shown = near, _disc(points, _away(cloud, middle), within), True
        if not np.array_equal(before.places, near.places):
            top, shown = _finer(top, near, middle, known)
        found = top.estimate(radius)
        unlike = by_half * _unlike_half(found, near, middle, radius, known)
        return _Top(Estimate(found.value, math.hypot(found.sd, unlike, shared_step(points.step, top.sd))), shown)
    top, flat = Top(near, middle, even=True), _flat(near)
    return _Top(_faint(top, Estimate(flat.value, math.hypot(flat.sd, top.misfit))), False)


def _finer(wide: Top, near: Points, middle: Array, known: Estimate | None) -> tuple[Top, bool]:
    """Return the top of a disc near the middle (2,), and whether it shows a curvature; if not, with that of a wider disc, which may hold skirt."""
    top = Top(near, middle, even=False).bent(known)
    if top.is_curved:
        return top, True
    of_wide = Estimate(wide.curvature, math.hypot(wide.curvature_sd, ROUGHLY * wide.curvature))
    bent = top.bent(of_wide)
    return (bent if bent.is_convex else wide), False


def _unlike_half(found: Estimate, near: Points, middle: Array, radius: float, known: Estimate | None) -> float:
    """Return the difference, m, of the heights from a disc and from its inner half, beyond what noise explains (Hausman, 1978).

    Then the disc holds skirt, which no quadratic follows.
    """
    away = _away(near.cloud, middle)
    inner = np.flatnonzero(away <= 0.5 * float(away.max()))
    if inner.size < LEAST_POINTS:
        return 0.0
    half = Top(near.at(inner), middle, even=False).bent(known)
    if not half.is_curved:
        return 0.0
    other = half.estimate(radius)
    by_chance = max(other.sd**2 - found.sd**2, 0.0)
    return math.sqrt(max((other.value - found.value) ** 2 - by_chance, 0.0))


def _of_highest(points: Points, top: Top, reach: float, known: Estimate | None) -> tuple[Top, float]:
    """Return the top about the highest points, and its reach, where it is clearly curved and much smaller; else as given.

    Where part of the skirt was taken for contact, the middle of all points lies beside the top. On a flat face the highest
    points lie anywhere.
    """
    cloud = points.cloud
    high = cloud[:, cloud[2] > quantile(cloud[2], 1.0 - HIGH)]
    if high.shape[1] < LEAST_POINTS:
        return top, reach
    middle = np.array([quantile(high[0]), quantile(high[1])])
    within = AROUND * math.sqrt(2.0 * quantile(_away(high, middle)))
    if within > 0.7 * reach:
        return top, reach
    other = Top(_disc(points, _away(cloud, middle), within), middle, even=False).bent(known)
    return (other, within) if other.is_curved else (top, reach)


def _faint(top: Top, flat: Estimate) -> Estimate:
    """Return the height of a top that is flat, or nearly so.

    Taken for flat, a faint cap comes out too low by half its sag. Before it is seen, a top is flat or round, one as likely as
    the other, and a round one falls within the disc by a half-normal share of its depth.
    """
    sag, spread = top.sag, SAG * abs(flat.value)
    likely = _sag(sag, max(spread, 1e-9))
    return Estimate(flat.value + 0.5 * likely.value, math.hypot(flat.sd, 0.5 * likely.sd))


def _sag(seen: Estimate, spread: float) -> Estimate:
    """Return the sag, m, that is 0 or, as likely, half-normal with a `spread`, m, once it is seen with an error."""
    seen = Estimate(seen.value, max(seen.sd, 1e-12))
    total = seen.sd**2 + spread**2
    middle, sd = seen.value * spread**2 / total, seen.sd * spread / math.sqrt(total)
    t = middle / sd
    if t < -30.0:  # so surely none that the tail is less than any number
        return Estimate(0.0, 0.0)
    above = max(0.5 * math.erfc(-t / math.sqrt(2.0)), 1e-300)
    hazard = math.exp(-0.5 * t * t) / math.sqrt(2.0 * math.pi) / above
    odds = (
        2.0
        * above
        * seen.sd
        / math.sqrt(total)
        * math.exp(min(0.5 * (seen.value / seen.sd) ** 2 * spread**2 / total, 700.0))
    )
    share = odds / (1.0 + odds)
    mean, variance = middle + sd * hazard, sd * sd * max(1.0 - t * hazard - hazard**2, 0.0)
    return Estimate(share * mean, math.sqrt(share * variance + share * (1.0 - share) * mean**2))


def _away(cloud: Array, middle: Array) -> Array:
    """Return the squared lateral distances (n,) of points from a place."""
    x, y = cloud[0] - middle[0], cloud[1] - middle[1]
    return np.asarray(x * x + y * y)


def _disc(points: Points, away: Array, radius: float) -> Points:
    """Return the points whose squared distance lies within a radius, or all where that leaves too few."""
    near = np.flatnonzero(away <= radius * radius)
    return points.at(near) if near.size >= LEAST_POINTS else points


def _flat(points: Points) -> Estimate:
    """Return Tukey's robust mean of heights that come in steps, m, and its standard deviation."""
    z, n = points.cloud[2], len(points)
    center, one = quantile(z), np.ones((1, n))
    q, sd = settled(one, z - center, points.step)
    own = sd * sd / n + float(points.shared(one)[0, 0]) / n**2
    evens = sd if points.noise is None else min(points.noise.sd_beside_counts(points.step), sd)
    return Estimate(center + float(q[0]), math.hypot(math.sqrt(own), shared_step(points.step, evens)))
