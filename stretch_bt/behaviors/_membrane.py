"""The height of a sphere's top by the whole membrane, where the run knows how it is mounted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stretch_bt import perception
from stretch_bt.errors import IllConditioned
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.types import UNDEFORMED, FloatArray, LabelArray, MaskArray
from stretch_bt.units import Estimate, Length

if TYPE_CHECKING:
    from stretch_bt.behaviors.records import Mounting
    from stretch_bt.hardware.hand import HandGeometry

__all__ = ["as_touched", "camera_off", "height_of_top", "is_mounted", "left_of_pattern", "lift_at", "strain_of"]

APART = 3.0  # standard deviations by which it may differ from the height of the contact alone
STATIC = 2.5e-3  # of the distance, by which a depth camera is off in places where nothing shows it (SR300 and SR305, 0.5 mm at 0.2 m)
MOUNTED = Estimate(
    0.1, 0.05
)  # strain of a membrane whose mount nobody told, an assumption: hands are mounted at some 0.05 to 0.15
LEAST_STRAIN = 0.01  # of a slack one that is pressed
LEAST_FLAT = 200  # pixels of the undeformed membrane that show it


def is_mounted(mounting: Mounting | None) -> bool:
    """Return whether something knows by how much the mounts stretch the membrane."""
    return mounting is not None and mounting.prestretch > 0


def height_of_top(
    hand: HandGeometry,
    mounting: Mounting | None,
    points: FloatArray,
    valid: MaskArray,
    labels: LabelArray,
    stretch: Length,
    curvature: Estimate | None,
    *,
    by_membrane: bool = True,
) -> tuple[Estimate, bool]:
    """Return the height of a top, z of the membrane frame, m, and whether the whole membrane told it.

    By the whole membrane, where that may be and can tell it, else by the contact.
    """
    reach = hand.reach(stretch)
    top = perception.track_height(points, valid, labels, curvature=curvature, reach=reach)
    if curvature is not None and by_membrane:
        whole = _by_membrane(hand, mounting, points, valid, stretch, curvature, top)
        if whole is not None:
            return whole, True
    return top, False


def _by_membrane(
    hand: HandGeometry,
    mounting: Mounting | None,
    points: FloatArray,
    valid: MaskArray,
    stretch: Length,
    curvature: Estimate,
    contact: Estimate,
) -> Estimate | None:
    """Return the height, z of the membrane frame, m, of a sphere's top, which the contact alone tells as `contact`.

    None where no mount is known, what is seen is no sphere pressed into the middle of such a membrane, or the two heights do not agree.
    """
    if mounting is None or not is_mounted(mounting):
        return None
    sag = Estimate(mounting.sag, mounting.sag_sd)
    try:
        membrane = perception.mounted_membrane(
            hand.gauge, hand.width, hand.thickness, mounting.prestretch, stretch, sag
        )
        found = perception.membrane_height(points, valid, membrane, curvature, contact.value)
    except IllConditioned:
        return None
    return found if abs(found.value - contact.value) < APART * math.hypot(found.sd, contact.sd) else None


def strain_of(gauge: Length, mounting: Mounting | None, stretch: Length) -> Estimate:
    """Return by how much the free membrane is stretched at a stretch, m, as a part of its gauge, m."""
    known = mounting is not None and is_mounted(mounting)
    mounted = Estimate(mounting.prestretch / gauge, 0.0) if mounting is not None and known else MOUNTED
    return Estimate(max(mounted.value + stretch / gauge, LEAST_STRAIN), mounted.sd)


def as_touched(
    hand: HandGeometry,
    mounting: Mounting | None,
    top: Estimate,
    points: FloatArray,
    labels: LabelArray,
    stretch: Length,
) -> Estimate:
    """Return the height of what is touched under a top of the membrane, m: a flat one lifts the membrane by its edges.

    `points` (h, w, 3), m, are in the membrane frame, NaN where invalid, `labels` (h, w) the classes.
    """
    lift = lift_at(hand, mounting, top.value, points, labels, stretch)
    return Estimate(top.value - lift.value, math.hypot(top.sd, lift.sd))


def lift_at(
    hand: HandGeometry,
    mounting: Mounting | None,
    height: Length,
    points: FloatArray,
    labels: LabelArray,
    stretch: Length,
) -> Estimate:
    """Return how far the membrane, whose top has a height, stands above what is touched, m; the arrays are those of `as_touched`."""
    strain = strain_of(hand.gauge, mounting, stretch)
    return perception.lift_off(points, labels, height, hand.thickness, strain, hand.gauge)


def left_of_pattern(pattern: Pattern | None) -> Length | None:
    """Return what a learned static error misses of the camera's, m; None where none is learned."""
    return pattern.left if pattern is not None else None


def camera_off(pattern: Pattern | None, points: FloatArray, labels: LabelArray, distance: Length) -> Length:
    """Return by how much a camera is off over all of a contact, m: what a learned static error misses, or what the flat membrane shows.

    `points` (h, w, 3), m, are in the membrane frame, NaN where invalid, `labels` (h, w) the classes, `distance` that of the flat membrane.
    """
    left = left_of_pattern(pattern)
    if left is not None:
        return left
    z = points[..., 2][(labels == UNDEFORMED) & np.isfinite(points[..., 2])]
    if z.size < LEAST_FLAT:
        return STATIC * distance
    noise = MAD_TO_SD * quantile(np.abs(np.diff(z))) / math.sqrt(2.0)
    off = math.sqrt(max(float(np.mean(z.astype(np.float64) ** 2)) - noise**2, 0.0))
    return min(off, STATIC * distance)  # a membrane that hangs stands off its plane as well
