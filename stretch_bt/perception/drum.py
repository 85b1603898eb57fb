"""How far a membrane that resists bending stands above a flat top: its edges lift it, and it spans the rest as a drum."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.arguments import check_estimates
from stretch_bt.errors import InvalidInput, NoContact, shown
from stretch_bt.perception.surface import check_labels, check_points
from stretch_bt.perception.top import Places, Points, Top, disc_of
from stretch_bt.perception.tops import noise_around
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Estimate

__all__ = ["lift_of_flat", "lift_off"]

# Over 300 discs and blocks of 12 to 40 mm with edges of 0.5 to 10 mm under solved sheets of gauges of 50 to 120 mm, 1 to 2 mm thick, pressed
# 3 to 14 mm deep (`python -m benchmarks.lift_off --bodies 300 --seed 0 --fit`): the lift over the thickness, by powers of depth,
# half the size and thickness over the gauge, of the strain, and of the face's length along j over its width along i, as the sides along the
# stretch are those that lift it; the factor, and the standard deviation as a part of the lift.
FACTOR, DEPTH, SIZE, THICKNESS, STRAIN, ASPECT = 0.315, 0.781, -0.370, 0.103, -0.385, 0.762
PART = 0.3
LONGEST = 3.3  # of length over width, or the reverse: faces of 12 to 40 mm
# The bow of a contact is its curvature times the square of its radius over twice the lift of a flat top: 1 for a drum of that lift. The sheet
# is lifted by 1 / (1 + (bow / BOW)^POWER) of that. A flat top under a drum and a top that bows itself, which lifts nothing, look alike from a
# bow of ALIKE_FROM to one of ALIKE_TO; the part has a standard deviation of ALIKE there, which falls off as 1 / (1 + (bow / ALIKE_TO)^ALIKE_POWER).
# BOW and POWER fit 112 discs, half of them flat, the others with tops of 1.5 to 60 times their radius; the rest was set by hand to cover them.
# `python -m benchmarks.bowed_tops` draws others.
BOW, POWER = 2.3, 3.5
ALIKE, ALIKE_FROM, ALIKE_TO, ALIKE_POWER = 0.35, 1.0, 10.0, 6.0
CLEAR = 1e3  # a bow that is clearly none of a drum
INSIDE = 0.75  # share of the contact's radius within which its curvature is fitted
MOST, LEAST = 4000, 30  # points of the contact that are looked at; of fewer the top may be flat or round
SHALLOW, SMALL = 1e-3, 3e-3  # m; the law is not asked for less depth, or for a smaller contact whose shape is not seen


def lift_of_flat(
    height: float, radius: float, thickness: float, strain: float, gauge: float, aspect: float = 1.0
) -> float:
    """Return how far a membrane of a gauge stands above a flat top whose contact has a radius, m, and is so many times as long along j."""
    depth, size, thin = height / gauge, radius / gauge, thickness / gauge
    return float(thickness * FACTOR * depth**DEPTH * size**SIZE * thin**THICKNESS * strain**STRAIN * aspect**ASPECT)


def lift_off(
    points: FloatArray, labels: LabelArray, height: float, thickness: float, strain: Estimate, gauge: float
) -> Estimate:
    """Return how far the membrane stands above the top of what it touches, m: none over a round top, all of it over a flat one.

    Parameters
    ----------
    points : (h, w, 3) float, m, membrane frame
    labels : (h, w) uint8
        Classes as `segment` gives them.
    height : m
        Height of the membrane's top above its clamps.
    thickness : m
        Thickness of the membrane.
    strain
        Strain of the free membrane in its mounts, above 0, with its standard deviation.
    gauge : m
        Length of the membrane between its mounts when it is not stretched.

    Raises
    ------
    InvalidInput
        A number is not finite; thickness, strain or gauge is not above 0; points are no image, or the labels have another shape.
    NoContact
        No point in contact has depth.
    IllConditioned
        The points in contact lie on one line.
    """
    _check(points, labels, height, thickness, strain, gauge)
    contact = _contact(points, labels)
    middle, away, radius = disc_of(contact.cloud)
    depth, radius = max(height, SHALLOW), max(radius, SMALL)
    most = lift_of_flat(depth, radius, thickness, strain.value, gauge, _aspect(contact.cloud))
    if most == 0.0:
        return Estimate(0.0, 0.0)
    part = math.hypot(PART, STRAIN * strain.sd / strain.value)
    near = np.flatnonzero(away <= (INSIDE * radius) ** 2)
    if near.size < LEAST:
        return Estimate(0.5 * most, most * min(math.hypot(0.5, math.sqrt(0.5) * part), 1.0))
    top = Top(contact.at(near), middle, even=True)
    bow, bow_sd = (min(value * radius**2 / (2.0 * most), CLEAR) for value in (top.curvature, top.curvature_sd))
    flat = _part(bow)
    unsure = max(_part(bow - bow_sd) - flat, flat - _part(bow + bow_sd))
    return Estimate(flat * most, most * min(math.hypot(part * flat, unsure, _alike(bow)), 1.0))


def _part(bow: float) -> float:
    """Return the part of a flat top's lift that remains over a top with this bow."""
    return float(1.0 / (1.0 + (max(bow, 0.0) / BOW) ** POWER))


def _alike(bow: float) -> float:
    """Return the standard deviation of that part, as flat tops and others look alike."""
    bow = max(bow, 0.0)
    return float(ALIKE * min(bow / ALIKE_FROM, 1.0) / (1.0 + (bow / ALIKE_TO) ** ALIKE_POWER))


def _aspect(cloud: FloatArray) -> float:
    """Return how many times as long along j as along i a contact of points (3, n), m, is."""
    across, along = (float(np.std(line)) for line in cloud[:2])
    return min(max(along / max(across, 1e-9), 1.0 / LONGEST), LONGEST)


def _check(
    points: FloatArray, labels: LabelArray, height: float, thickness: float, strain: Estimate, gauge: float
) -> None:
    """Refuse numbers of which no lift follows."""
    check_estimates(strain=strain)
    if not (is_number(height) and is_number(strain.sd) and strain.sd >= 0.0):
        raise InvalidInput(
            f"height and the deviation of the strain must be finite, not {shown(height)} m and {strain.sd}"
        )
    if not all(is_number(value) and value > 0.0 for value in (thickness, strain.value, gauge)):
        raise InvalidInput(
            f"thickness, strain and gauge must be above 0 and finite, not {shown(thickness)} m, {strain.value} and {shown(gauge)} m"
        )
    check_points(points)
    check_labels(labels, points)


def _contact(points: FloatArray, labels: LabelArray) -> Points:
    """Return at most MOST of the points in contact, with the noise of their frame."""
    valid = np.asarray(np.isfinite(points).all(axis=2))
    places: Places = np.flatnonzero((labels == CONTACT) & valid)
    if not places.size:
        raise NoContact("no point in contact has depth, so that no top is seen; press deeper")
    noise = noise_around(points, valid, places)
    some = places[:: -(-places.size // MOST)]
    cloud = np.ascontiguousarray(points.reshape(-1, 3)[some].T, dtype=np.float64)
    return Points(cloud, some, labels.shape[1], noise)
