"""How far a membrane that resists bending stands above a flat top: its edges lift it, and it spans the rest as a drum."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_estimates
from stretch_bt.errors import InvalidInput, NoContact, shown
from stretch_bt.perception.surface import check_labels, check_points
from stretch_bt.perception.top import Places, Points, Top, disc_of
from stretch_bt.perception.tops import noise_around
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Estimate

__all__ = ["lift_off"]

Array = npt.NDArray[np.float64]

# Over 260 discs, blocks, bowed discs, balls and lying cylinders in five noises (`python benchmarks/bowed_tops.py --seed 1000 --bodies 260`), and
# half of the balls and caps of `benchmarks.height_noise`: how far the top that `track_height` reads, which over a wide face lies at its edges,
# stands above a flat top, over the thickness, by powers of the depth and the contact's radius and the thickness over the gauge, of the strain, and
# of the contact's length along j over its width along i; the factor, and the standard deviation as a part of the lift. The contact is as a camera
# shows it, which noise makes wider than the face. It and what follows are of greatest likelihood; the part and ALIKE were then raised by an
# eighth and by three quarters, to cover others. (`python -m benchmarks.lift_off` has the law of the middle of a face that is known.)
FACTOR, DEPTH, SIZE, THICKNESS, STRAIN, ASPECT = 2.262, 0.748, 0.215, 0.348, -0.434, 0.507
PART = 0.55
LONGEST = 3.3  # of length over width, or the reverse: faces of 12 to 40 mm
# The bow of a contact is its curvature times the square of its radius over twice the lift of a flat top: 1 for a drum of that lift. It is taken
# near the middle, within INSIDE of the radius, and as far as noise hides it there, from the bow within OUTSIDE, of which it is OUTER with a
# standard deviation of OUTER_SD, as parts. A round top bows alike everywhere; a flat one whose skirt counts as contact bows less in its middle, so
# that its bow counts less by the power GREW of (1 + that) / (1 + the outer one), at most MOST_GREW.
INSIDE, OUTSIDE = 0.45, 0.75
OUTER, OUTER_SD, LEAST_BOW, LEAST_BOW_SD = 0.8, 0.085, 0.3, 0.01
GREW, MOST_GREW = 2.7, 1.3
# The sheet is lifted by 1 / (1 + (bow / BOW)^POWER) of what it is over a flat top. A flat top and one that bows itself, which lifts nothing, look
# alike from a bow of ALIKE_FROM to one of ALIKE_TO; the part has a standard deviation of ALIKE there, which falls off as
# 1 / (1 + (bow / ALIKE_TO)^4).
BOW, POWER = 3.16, 4.0
ALIKE, ALIKE_FROM, ALIKE_TO = 0.35, 0.95, 5.8
LEAST_SD = 25e-6  # m, standard deviation of a lift at least
NODES = np.linspace(-3.0, 3.0, 13)  # of a normal distribution, in standard deviations, with their weights
WEIGHTS = np.exp(-(NODES**2) / 2.0) / np.exp(-(NODES**2) / 2.0).sum()
CLEAR = 1e3  # a bow that is clearly none of a drum
MOST, LEAST = 4000, 30  # points of the contact that are looked at; of fewer the top may be flat or round
SHALLOW, SMALL = 1e-3, 3e-3  # m; the law is not asked for less depth, or for a smaller contact whose shape is not seen


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
    most = _of_flat(depth, radius, thickness, strain.value, gauge, _aspect(contact.cloud))
    if most == 0.0:
        return Estimate(0.0, 0.0)
    part = math.hypot(PART, STRAIN * strain.sd / strain.value)
    inner, outer = (
        _bow(contact, middle, away, share * radius, radius**2 / (2.0 * most)) for share in (INSIDE, OUTSIDE)
    )
    if outer is None:
        return Estimate(0.5 * most, most * min(math.hypot(0.5, math.sqrt(0.5) * part), 1.0))
    flat = _part(_in_the_middle(inner, outer), outer.value)
    sd = most * min(math.hypot(part * flat.value, flat.sd), 1.0)
    return Estimate(flat.value * most, math.hypot(sd, min(most, LEAST_SD)))


def _of_flat(height: float, radius: float, thickness: float, strain: float, gauge: float, aspect: float) -> float:
    """Return the lift over a flat top whose contact has a radius, m, and is so many times as long along j as along i, m."""
    depth, size, thin = height / gauge, radius / gauge, thickness / gauge
    return float(thickness * FACTOR * depth**DEPTH * size**SIZE * thin**THICKNESS * strain**STRAIN * aspect**ASPECT)


def _bow(contact: Points, middle: Array, away: Array, within: float, scale: float) -> Estimate | None:
    """Return the bow of a contact within a distance, m, of its middle, `scale`, m, times its curvature; None where too few points show it."""
    near = np.flatnonzero(away <= within**2)
    if near.size < LEAST:
        return None
    top = Top(contact.at(near), middle, even=True)
    return Estimate(min(top.curvature * scale, CLEAR), min(top.curvature_sd * scale, CLEAR))


def _in_the_middle(inner: Estimate | None, outer: Estimate) -> Estimate:
    """Return the bow in the middle of a contact, from the one that is seen there, if any, and the one farther out."""
    found = [(OUTER * outer.value, math.hypot(OUTER * outer.sd, OUTER_SD * max(outer.value, LEAST_BOW)))]
    found += [] if inner is None else [(inner.value, max(inner.sd, LEAST_BOW_SD))]
    weights = [1.0 / sd**2 for _, sd in found]
    mean = sum(w * value for w, (value, _) in zip(weights, found, strict=True)) / sum(weights)
    return Estimate(mean, 1.0 / math.sqrt(sum(weights)))


def _part(bow: Estimate, outer: float) -> Estimate:
    """Return the part of a flat top's lift that remains over a top with this bow in its middle, in the mean over what that may be."""
    bows = np.maximum(bow.value + bow.sd * NODES, 0.0)
    bows *= np.minimum((1.0 + bows) / (1.0 + max(outer, 0.0)), MOST_GREW) ** GREW
    parts = 1.0 / (1.0 + (bows / BOW) ** POWER)
    mean, bowed = float(parts @ WEIGHTS), float(bows @ WEIGHTS)
    alike = ALIKE * min(bowed / ALIKE_FROM, 1.0) / (1.0 + (bowed / ALIKE_TO) ** 4)
    return Estimate(mean, math.hypot(math.sqrt(max(float(parts**2 @ WEIGHTS) - mean**2, 0.0)), alike))


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
