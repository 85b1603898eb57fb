"""The top of what the membrane begins to touch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stretch_bt import perception
from stretch_bt.behaviors._membrane import as_touched
from stretch_bt.behaviors._readings import FirstTouch
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.units import Estimate, Length

if TYPE_CHECKING:
    from stretch_bt.behaviors.records import Mounting

__all__ = ["top_of"]


def top_of(
    frame: DepthFrame, hand: HandGeometry, mounting: Mounting | None = None
) -> tuple[Estimate, Length, FirstTouch] | None:
    """Return how deep the top of a contact stands in the membrane, m, what of its deviation all touches share, m, and what was seen.

    None where nothing is in contact. A flat top lifts the membrane: that is taken off, and its error is the same at each touch.
    """
    try:
        contact = perception.find_contact(frame)
        points, valid = perception.deproject(frame)
        points = perception.to_membrane(points, frame.plane_distance or 0.0)
        stretch = frame.stretch or 0.0
        seen = perception.track_height(points, valid, contact.labels, reach=hand.reach(stretch))
        top = as_touched(hand, mounting, seen, contact.surface, contact.labels, stretch)
        shared = math.sqrt(max(top.sd**2 - seen.sd**2, 0.0))
        return top, shared, FirstTouch(points, valid, contact.labels)
    except NoAnswer:
        return None
