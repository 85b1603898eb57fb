"""Height of the object's top, the highest of all that touch."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_estimates
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact, shown
from stretch_bt.perception.clean import without_flying
from stretch_bt.perception.edge_of_view import check_top_in_view
from stretch_bt.perception.high_part import HighMeans
from stretch_bt.perception.leaning import lean_of
from stretch_bt.perception.leaning_face import face_of
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.pitch import pitch_of
from stretch_bt.perception.robust import sample
from stretch_bt.perception.steps import step_of
from stretch_bt.perception.stripes import NO_STRIPES
from stretch_bt.perception.surface import check_array, check_labels, check_points, finite
from stretch_bt.perception.top import Places, Points
from stretch_bt.perception.top_disc import LEAST_POINTS, DiscTop, top_by_discs
from stretch_bt.perception.tops import contacts, noise_around, summits, surroundings
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray, MaskArray
from stretch_bt.perception.wide_top import by_wide_discs
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Estimate

__all__ = ["top_of_pixels", "top_of_points", "track_height", "within_reach"]

Array = npt.NDArray[np.float64]

MOST_CURVED = 1e10  # 1/m, of an atom
PARTS = 2  # high parts of a contact that are tried

MOST = 20_000  # points, whose height is known to far less than a camera's count, and not better by more
RUN = 64  # neighbours that are kept together, since they show how far noise is alike
UNSEEN = (
    "no pixel in contact has depth, so that the top is not seen; press deeper, or keep reflections off the membrane"
)


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
        Too few pixels for a height with its error, the top may lie outside of the view, or the height is one that no membrane reaches.
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
    tops, refusals = list[DiscTop](), list[IllConditioned]()
    for places in found:
        try:
            tops += _tops(points, valid, _some(places), noise, others, curvature)
        except IllConditioned as refusal:
            refusals.append(refusal)
    if not tops:
        raise refusals[0]
    touching = labels == CONTACT
    top = _highest(points, valid, touching, noise, others, curvature, tops)
    if noise is not None:
        check_top_in_view(points, valid, touching, noise, top)
    return within_reach(top, reach)


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
    tops: list[DiscTop],
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
    return face.of(top if curved and not lean.is_hidden else lean.of(top))


def _highest_part(
    points: FloatArray,
    valid: MaskArray,
    touching: MaskArray,
    noise: NoiseSpectrum,
    others: FloatArray,
    curvature: Estimate | None,
    tops: list[DiscTop],
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
) -> Iterator[DiscTop]:
    """Yield the tops of the contact at some pixels (n,): of one, or of two that look like a long one."""
    touching = _points(points.reshape(-1, 3)[places], places, valid.shape[1], noise)
    step = step_of(touching.cloud[2], others)
    noise = None if noise is None else noise.beside_counts(step)
    touching = replace(touching, step=step, noise=noise)
    if noise is None:
        yield top_by_discs(touching, curvature)
        return
    around = surroundings(points, valid, touching, noise)
    for part in summits(touching, around, max(noise.white_sd, touching.step / math.sqrt(12.0))):
        top = top_by_discs(part, curvature)
        alone = noise.area <= 1.0 and noise.stripes == NO_STRIPES
        yield top if alone else DiscTop(by_wide_discs(top.height, part, around), top.is_curved)


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
    return top_by_discs(replace(seen, step=step_of(seen.cloud[2], seen.cloud[2])), by_half=by_half).height


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
