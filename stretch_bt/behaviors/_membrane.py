"""The height of a sphere's top by the whole membrane, where the run knows how it is mounted."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt import perception
from stretch_bt.errors import IllConditioned
from stretch_bt.perception.types import FloatArray, LabelArray, MaskArray
from stretch_bt.tree.context import Context
from stretch_bt.units import Estimate, Length

__all__ = ["FRAME_NOISE", "MEMBRANE_NOISE", "Mounting", "height_of_top", "keep_how", "told_by_membrane"]

FRAME_NOISE = 3e-4  # m, by which the height of a top is off at least in one frame of the `bench` camera
MEMBRANE_NOISE = 1.2e-4  # m, the same where the whole membrane tells it
TOLD = "told"
APART = 3.0  # standard deviations by which it may differ from the height of the contact alone
CONTACT_SD = 1e-4  # m; of the latter, which states too little


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
) -> tuple[Estimate, Length]:
    """Return the height of a top, z of the membrane frame, m, and by how much such a height is off in one frame at least, m.

    By the whole membrane, where that may be and can tell it, else by the contact.
    """
    reach = context.hand.geometry.reach(stretch)
    top = perception.track_height(points, valid, labels, curvature=curvature, reach=reach)
    if curvature is not None and by_membrane:
        whole = _by_membrane(context, points, valid, stretch, curvature, top)
        if whole is not None:
            return whole, MEMBRANE_NOISE
    return top, FRAME_NOISE


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
    sure = math.hypot(found.sd, contact.sd, CONTACT_SD)
    return found if abs(found.value - contact.value) < APART * sure else None
