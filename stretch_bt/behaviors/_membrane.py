"""The height of a sphere's top by the whole membrane, where the run knows how it is mounted."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt import perception
from stretch_bt.errors import IllConditioned
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.robust import MAD_TO_SD, quantile
from stretch_bt.perception.types import UNDEFORMED, FloatArray, LabelArray, MaskArray
from stretch_bt.tree.context import Context
from stretch_bt.units import Estimate, Length

__all__ = [
    "Mounting",
    "as_touched",
    "camera_off",
    "height_of_top",
    "keep_how",
    "left_of_pattern",
    "strain_of",
    "told_by_membrane",
]

TOLD = "told"
APART = 3.0  # standard deviations by which it may differ from the height of the contact alone
STATIC = 2.5e-3  # of the distance, by which a depth camera is off in places where nothing shows it (SR300 and SR305, 0.5 mm at 0.2 m)
MOUNTED = Estimate(
    0.1, 0.05
)  # strain of a membrane whose mount nobody told, an assumption: hands are mounted at some 0.05 to 0.15
LEAST_STRAIN = 0.01  # of a slack one that is pressed
LEAST_FLAT = 200  # pixels of the undeformed membrane that show it


@dataclass(frozen=True, slots=True)
class Mounting:
    """How a force model says that the membrane is mounted: its stretch at stretch 0, m, and how far it hangs there in its middle, m."""

    prestretch: Length
    hang: Estimate


def keep_how(context: Context, *, by_membrane: bool) -> None:
    """Remember whether the whole membrane told the latest height of the top."""
    context.memory[Mounting, TOLD] = by_membrane


def told_by_membrane(context: Context) -> bool:
    """Return whether the whole membrane told the latest height of the top."""
    return bool(context.memory.get((Mounting, TOLD), False))


def height_of_top(
    context: Context,
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
    reach = context.hand.geometry.reach(stretch)
    top = perception.track_height(points, valid, labels, curvature=curvature, reach=reach)
    if curvature is not None and by_membrane:
        whole = _by_membrane(context, points, valid, stretch, curvature, top)
        if whole is not None:
            return whole, True
    return top, False


def _by_membrane(
    context: Context,
    points: FloatArray,
    valid: MaskArray,
    stretch: Length,
    curvature: Estimate,
    contact: Estimate,
) -> Estimate | None:
    """Return the height, z of the membrane frame, m, of a sphere's top, which the contact alone tells as `contact`.

    None where no mount is known, what is seen is no sphere pressed into the middle of such a membrane, or the two heights do not agree.
    """
    mount: Mounting | None = context.memory.get(Mounting)
    if mount is None:
        return None
    hand = context.hand.geometry
    try:
        membrane = perception.mounted_membrane(
            hand.gauge, hand.width, hand.thickness, mount.prestretch, stretch, mount.hang
        )
        found = perception.membrane_height(points, valid, membrane, curvature, contact.value)
    except IllConditioned:
        return None
    return found if abs(found.value - contact.value) < APART * math.hypot(found.sd, contact.sd) else None


def strain_of(context: Context, stretch: Length) -> Estimate:
    """Return by how much the free membrane is stretched at a stretch, m, as a part of its gauge."""
    mount: Mounting | None = context.memory.get(Mounting)
    gauge = context.hand.geometry.gauge
    mounted = Estimate(mount.prestretch / gauge, 0.0) if mount is not None else MOUNTED
    return Estimate(max(mounted.value + stretch / gauge, LEAST_STRAIN), mounted.sd)


def as_touched(context: Context, top: Estimate, points: FloatArray, labels: LabelArray, stretch: Length) -> Estimate:
    """Return the height of what is touched under a top of the membrane, m: a flat one lifts the membrane by its edges.

    `points` (h, w, 3), m, are in the membrane frame, NaN where invalid, `labels` (h, w) the classes.
    """
    hand = context.hand.geometry
    lift = perception.lift_off(points, labels, top.value, hand.thickness, strain_of(context, stretch), hand.gauge)
    return Estimate(top.value - lift.value, math.hypot(top.sd, lift.sd))


def left_of_pattern(context: Context) -> Length | None:
    """Return what a learned static error misses of the camera's, m; None where none is learned."""
    pattern: Pattern | None = context.memory.get(Pattern)
    return pattern.left if pattern is not None else None


def camera_off(context: Context, points: FloatArray, labels: LabelArray, distance: Length) -> Length:
    """Return by how much a camera is off over all of a contact, m: what a learned static error misses, or what the flat membrane shows.

    `points` (h, w, 3), m, are in the membrane frame, NaN where invalid, `labels` (h, w) the classes, `distance` that of the flat membrane.
    """
    left = left_of_pattern(context)
    if left is not None:
        return left
    z = points[..., 2][(labels == UNDEFORMED) & np.isfinite(points[..., 2])]
    if z.size < LEAST_FLAT:
        return STATIC * distance
    noise = MAD_TO_SD * quantile(np.abs(np.diff(z))) / math.sqrt(2.0)
    off = math.sqrt(max(float(np.mean(z.astype(np.float64) ** 2)) - noise**2, 0.0))
    return min(off, STATIC * distance)  # a membrane that hangs stands off its plane as well
