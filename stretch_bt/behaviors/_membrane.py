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

APART = 3.0  # largest difference from the height by the contact alone, in standard deviations
STATIC = 2.5e-3  # a depth camera's error over the distance in places where nothing shows it (SR300 and SR305, 0.5 mm at 0.2 m)
MOUNTED = Estimate(
    0.1, 0.05
)  # strain of a membrane whose mounting is unknown, an assumption: hands are mounted at some 0.05 to 0.15
LEAST_STRAIN = 0.01  # least strain of a slack membrane that is pressed
LEAST_FLAT = 200  # least number of pixels of the undeformed membrane that show the camera's error


def is_mounted(mounting: Mounting | None) -> bool:
    """Return whether it is known how far the mounts stretch the membrane."""
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
    """Return the height of a top, z of the membrane frame, m, and whether the whole membrane gave it.

    The whole membrane gives it where `by_membrane` allows that and its shape fits, else the contact does.
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
    """Return the height of a sphere's top by the whole membrane, z of the membrane frame, m; `contact` is its height by the contact alone.

    None where no mount is known, the points show no sphere pressed into the middle of such a membrane, or the two heights do not agree.
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
    """Return the strain of the free membrane at a stretch, m, by its mounts and that stretch, over its gauge, m."""
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
    """Return the height of the object touched under a top of the membrane, m: a flat object lifts the membrane by its edges.

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
    """Return how far the membrane, whose top has a height, stands above the touched object, m; the arrays are as in `as_touched`."""
    strain = strain_of(hand.gauge, mounting, stretch)
    return perception.lift_off(points, labels, height, hand.thickness, strain, hand.gauge)


def left_of_pattern(pattern: Pattern | None) -> Length | None:
    """Return the residual of the camera's static error after the learned one, m; None where none is learned."""
    return pattern.left if pattern is not None else None


def camera_off(pattern: Pattern | None, points: FloatArray, labels: LabelArray, distance: Length) -> Length:
    """Return a camera's error that all of a contact shares, m: the residual of a learned static error, or the error that the flat membrane shows.

    `points` (h, w, 3), m, are in the membrane frame, NaN where invalid, `labels` (h, w) the classes, `distance`, m, the flat membrane's.
    """
    left = left_of_pattern(pattern)
    if left is not None:
        return left
    z = points[..., 2][(labels == UNDEFORMED) & np.isfinite(points[..., 2])]
    if z.size < LEAST_FLAT:
        return STATIC * distance
    noise = MAD_TO_SD * quantile(np.abs(np.diff(z))) / math.sqrt(2.0)
    off = math.sqrt(max(float(np.mean(z.astype(np.float64) ** 2)) - noise**2, 0.0))
    return min(off, STATIC * distance)  # a membrane that sags stands off its plane as well
