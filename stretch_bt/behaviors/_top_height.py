"""The height of a top over the table, also of one that is pressed flat."""

from __future__ import annotations

import numpy as np

from stretch_bt import perception
from stretch_bt.behaviors._membrane import as_touched
from stretch_bt.behaviors.records import Mounting
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.units import Estimate

__all__ = ["height_over_table"]

FLAT_SD = 0.0003  # m, standard deviation of a top whose contact does not show


def height_over_table(frame: DepthFrame, hand: HandGeometry, mounting: Mounting | None) -> Estimate:
    """Return the height of the top of the object in contact, m, world."""
    points, valid = perception.deproject(frame)
    seen = perception.to_membrane(points, frame.plane_distance or 0.0)
    stretch = frame.stretch or 0.0
    try:
        contact = perception.find_contact(frame)
        top = perception.track_height(seen, valid, contact.labels, reach=hand.reach(stretch))
        top = as_touched(hand, mounting, top, contact.surface, contact.labels, stretch)
    except NoAnswer:  # contact shows by its curvature, and a top that is pressed flat has none
        top = Estimate(perception.highest_of(np.where(valid[..., None], seen, np.nan)), FLAT_SD)
    return Estimate(top.value + (frame.hand_height or 0.0), top.sd)
