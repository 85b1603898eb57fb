"""The top of an object that the membrane begins to touch."""

from __future__ import annotations

from stretch_bt import perception
from stretch_bt.behaviors._readings import FirstTouch
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.units import Estimate

__all__ = ["top_of"]


# The membrane's lift over a flat top is not taken off here: `extrapolate_top` does so, since its error is the same for all touches.
def top_of(frame: DepthFrame, hand: HandGeometry) -> tuple[Estimate, FirstTouch] | None:
    """Return how deep the top of a contact stands in the membrane, m, and the points seen; None where nothing is in contact."""
    try:
        contact = perception.find_contact(frame)
        points, valid = perception.deproject(frame)
        points = perception.to_membrane(points, frame.plane_distance or 0.0)
        reach = hand.reach(frame.stretch or 0.0)
        top = perception.track_height(points, valid, contact.labels, reach=reach)
        return top, FirstTouch(points, valid, contact.labels)
    except NoAnswer:
        return None
