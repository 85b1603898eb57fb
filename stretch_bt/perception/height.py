"""Height of the object's top: the vertex of a quadratic on a curved top, a robust mean on a flat one."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception.robust import quantile, sample
from stretch_bt.perception.steps import shared_step, step_of
from stretch_bt.perception.surface import check_points
from stretch_bt.perception.top import Places, Top, settled
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["top_of_points", "track_height"]

Array = npt.NDArray[np.float64]

RIM = 0.75  # share of the contact's radius that the membrane's bend at the rim leaves alone
HIGH = 0.1  # share of the points that are the highest
AROUND = 1.5  # radii of those within which a top is sought
BEND = 0.35  # share of the radius of curvature within which a quadratic is a sphere to a thousandth of the radius

MOST = 40_000  # points, whose height is known to far less than a camera's count, and not better by more
RUN = 64  # neighbours that are kept together, since they show how far noise is alike


def track_height(
    points: FloatArray,
    valid: MaskArray,
    labels: LabelArray,
    *,
    curvature: Estimate | None = None,
    reach: float | None = None,
) -> Estimate:
    """Return the height of the object's top, z of the membrane frame, m.

    The vertex of a free quadratic over a disc has four times the variance of the mean; where the curvature of a round top is known, the
    mean and that tell its height.

    Parameters
    ----------
    points : (h, w, 3) float, m, membrane frame
    valid : (h, w) bool
    labels : (h, w) uint8
        Classes as `segment` gives them, of this frame or of an earlier one with the same contact.
    curvature
        Of the top, 1/m, where something else knows it; left aside where the points say otherwise by three standard deviations.
    reach : float, m
        How high or low the membrane can be (`HandGeometry.reach`), where that is known.

    Returns
    -------
    Estimate
        Its standard deviation counts that neighbouring pixels share their noise, as far as the contact itself shows it, and that heights
        come in steps, as far as the noise does not even them out.

    Raises
    ------
    NoContact
        No valid pixel is in contact.
    IllConditioned
        Too few pixels for a height with its error, or the height is one that no membrane reaches.
    """
    check_points(points, valid)
    if labels.shape != valid.shape:
        raise InvalidInput(f"labels need the shape of the frame, {valid.shape}, got {labels.shape}")
    places = np.flatnonzero(labels == CONTACT)
    places = _some(places[valid.reshape(-1)[places]])
    if curvature is not None and not (math.isfinite(curvature.value) and 0 < curvature.sd < math.inf):
        raise InvalidInput(f"curvature must be finite, 1/m, with a standard deviation above 0, not {curvature}")
    cloud, places = _cloud(points.reshape(-1, 3)[places], places)
    step = step_of(cloud[2], sample(points[..., 2], valid))
    return _within(_best(cloud, places, step, curvature), reach)


def top_of_points(points: FloatArray) -> Estimate:
    """Return the height, m, of the top of contact points (n, 3), m, membrane frame; raises as `track_height`.

    Its standard deviation is that of noise independent from point to point.
    """
    cloud, places = _cloud(points[_some(np.arange(len(points)))], None)
    return _best(cloud, places, step_of(cloud[2], cloud[2]))


def _within(height: Estimate, reach: float | None) -> Estimate:
    """Return a height that a membrane can have; others are refused."""
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


def _cloud(points: FloatArray, places: Places | None) -> tuple[Array, Places]:
    """Return the coordinates (3, n) of finite points, m, enough for a height, and the numbers of their pixels."""
    cloud = np.asarray(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise InvalidInput(f"contact points have shape (n, 3), got {cloud.shape}")
    cloud = np.ascontiguousarray(cloud.T)
    apart = 2 * np.arange(cloud.shape[1]) if places is None else places
    finite = np.isfinite(cloud[0]) & np.isfinite(cloud[1]) & np.isfinite(cloud[2])
    if not finite.all():
        cloud, apart = cloud[:, finite], apart[finite]
    if not apart.size:
        raise NoContact(
            "no pixel in contact has depth, so that the top is not seen; press deeper, or keep reflections off the membrane"
        )
    if apart.size < 12:
        raise IllConditioned(
            f"a height with its error needs at least twelve points in contact, there are {apart.size}; press deeper, or average frames"
        )
    return cloud, apart


def _best(cloud: Array, places: Places, step: float, known: Estimate | None = None) -> Estimate:
    """Return the height from a disc that the membrane's bend at the rim leaves alone."""
    middle = np.array([quantile(cloud[0]), quantile(cloud[1])])
    away = _away(cloud, middle)
    radius = math.sqrt(2.0 * quantile(away))
    reach = RIM * radius
    near, kept = _disc(cloud, places, away, reach)
    top = Top(near, kept, middle, even=False).bent(known)
    if not top.is_curved:
        top, reach = _of_highest(cloud, places, top, reach, known)
    if top.is_curved:
        within = min(reach, max(BEND / top.curvature, 0.3 * radius))
        middle = top.vertex(radius)
        before, (near, kept) = kept, _disc(cloud, places, _away(cloud, middle), within)
        if not np.array_equal(before, kept):
            top = Top(near, kept, middle, even=False).bent(known)
    if top.is_curved:
        found = top.estimate(radius)
        return Estimate(found.value, math.hypot(found.sd, shared_step(step, top.sd)))
    return _faint(Top(near, kept, middle, even=True), _flat(near[2], kept, step), radius)


def _of_highest(cloud: Array, places: Places, top: Top, reach: float, known: Estimate | None) -> tuple[Top, float]:
    """Return the top about the highest points, and its reach, where it is clearly curved and much smaller; else as given.

    Where part of the skirt was taken for contact, the middle of all points lies beside the top. On a flat face the highest
    points lie anywhere.
    """
    high = cloud[:, cloud[2] > quantile(cloud[2], 1.0 - HIGH)]
    if high.shape[1] < 12:
        return top, reach
    middle = np.array([quantile(high[0]), quantile(high[1])])
    within = AROUND * math.sqrt(2.0 * quantile(_away(high, middle)))
    if within > 0.7 * reach:
        return top, reach
    other = Top(*_disc(cloud, places, _away(cloud, middle), within), middle, even=False).bent(known)
    return (other, within) if other.is_curved else (top, reach)


def _faint(top: Top, flat: Estimate, radius: float) -> Estimate:
    """Return the height of a top that is flat, or nearly so.

    Taken for flat, a faint cap comes out too low by half its sag; taken for curved, a flat face comes out twice as
    uncertain. The weight of the vertex grows with the curvature's significance t as 1 - 2 / t^2, in the manner of the shrinkage of
    James and Stein.
    """
    t = top.significance
    if t * t <= 2.0:
        return flat
    weight, vertex = 1.0 - 2.0 / t**2, top.estimate(radius)
    variance = flat.sd**2 + weight * max(vertex.sd**2 - flat.sd**2, 0.0)
    return Estimate(flat.value + weight * (vertex.value - flat.value), float(np.sqrt(variance)))


def _away(cloud: Array, middle: Array) -> Array:
    """Return the squared lateral distances (n,) of points from a place."""
    x, y = cloud[0] - middle[0], cloud[1] - middle[1]
    return np.asarray(x * x + y * y)


def _disc(cloud: Array, places: Places, away: Array, radius: float) -> tuple[Array, Places]:
    """Return the points and places whose squared distance lies within a radius, or all where that leaves too few."""
    near = np.flatnonzero(away <= radius * radius)
    return (cloud.take(near, axis=1), places[near]) if near.size >= 12 else (cloud, places)


def _flat(z: Array, places: Places, step: float) -> Estimate:
    """Return Tukey's robust mean of heights that come in steps, m, and its standard deviation."""
    center = quantile(z)
    q, sd = settled(np.ones((1, len(z))), z - center, places)
    return Estimate(center + float(q[0]), math.hypot(sd / math.sqrt(len(z)), shared_step(step, sd)))
