"""The height of a top over the table, also of one that is pressed flat."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt import perception
from stretch_bt.behaviors._membrane import as_touched, camera_off
from stretch_bt.behaviors.records import Mounting
from stretch_bt.errors import IllConditioned, NoContact
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.perception.height import within_reach
from stretch_bt.perception.outlines.level_place import BLUR
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.surface import surface_of
from stretch_bt.perception.types import INVALID, FloatArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["height_over_table"]

FLAT_SD = 0.3e-3  # m; a faintly round top comes out low by as much, and a flat one stands as much under its membrane
KERNEL = 1e-3  # m, of the mean whose residual shows the noise: a flat top and its slopes leave little in it
EXTREME = (
    2.6  # standard deviations of a blurred pixel, by which at most noise raises the place that half a per cent exceed
)


def height_over_table(
    frame: DepthFrame, hand: HandGeometry, mounting: Mounting | None, pattern: Pattern | None = None
) -> Estimate:
    """Return the height of the top of the object in contact, m, world; `pattern` is the static error that the frame is already free of.

    Raises
    ------
    NoContact
        Nothing stands in the membrane.
    IllConditioned
        The frame shows no membrane in its plane, is too noisy, or shows a top that this hand's membrane cannot reach.
    """
    distance, stretch = frame.plane_distance or 0.0, frame.stretch or 0.0
    points, valid = perception.deproject(frame)
    seen = perception.to_membrane(points, distance)
    try:
        contact = perception.find_contact(frame)
        surface, labels = contact.surface, contact.labels
        top = perception.track_height(seen, valid, labels, reach=hand.reach(stretch))
        top = as_touched(hand, mounting, top, surface, labels, stretch)
    except NoContact:  # contact shows by its curvature, and a top that is pressed flat has none
        surface, labels = seen, np.full(valid.shape, INVALID, np.uint8)
        top = within_reach(_highest(seen, valid), hand.reach(stretch))
    off = camera_off(pattern, surface, labels, distance)
    return Estimate(top.value + (frame.hand_height or 0.0), math.hypot(top.sd, off))


def _highest(seen: FloatArray, valid: MaskArray) -> Estimate:
    """Return the height, m, membrane frame, of the highest place of points (h, w, 3), m, where they are valid (h, w).

    Its standard deviation is at least the noise of one pixel, and more where noise that pixels share outlasts the blur.
    """
    top = perception.highest_of(np.where(valid[..., None], seen, np.nan))
    surface = surface_of(seen, valid, KERNEL)
    if surface is None:
        raise IllConditioned(
            "no two pixels that touch have depth, so that the noise of the top is unknown; keep reflections off the membrane"
        )
    shared = EXTREME * surface.length / math.hypot(BLUR, surface.length)
    return Estimate(top, math.hypot(FLAT_SD, surface.noise * max(shared, 1.0)))
