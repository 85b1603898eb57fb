"""Tracking the height of the object's top."""

import math
from copy import deepcopy

from stretch_bt import perception
from stretch_bt.behaviors._membrane import as_touched, camera_off, height_of_top
from stretch_bt.behaviors.records import Mounting, ObservedTop, Rise
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.types import Contact, Sphere
from stretch_bt.tree.ports import Behavior, In, InOut, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length


@node
class TrackHeight(Behavior):
    """Measure the height of the object's top through the membrane; FAILURE when nothing is in contact.

    With a contact it is the height of its top, of the highest where there are several: in the world when the frame knows where the
    hand is, else above the flat membrane. Its deviation counts how many pixels share the camera's noise, and the camera's error
    over all of the contact: the residual of a learned pattern and its uncertainty of the membrane's sag, or else the error
    that the undeformed membrane shows. Over a flat top the membrane stands a little higher, as its edges bend it; that is taken off.

    Without a contact it is how far the highest place has risen above the first frames, on any soft sensor.

    With a sphere, where it is known how the membrane is mounted, the whole membrane gives the height, by the shape that the
    solved sheet has over such a sphere. The contact alone gives it where that shape does not fit.
    """

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # frame to measure in
    contact: In[Contact | None] = None  # where the top is; without it, frames are followed one by one
    sphere: In[Sphere | None] = None  # sphere fitted to the top in contact before; with it the height is more certain
    pattern: In[Pattern | None] = None  # static error of the camera, as far as it was learned
    mounting: In[Mounting | None] = None  # mounting of the membrane, as far as it is known
    rise: InOut[Rise | None]  # the sensor at rest, by the frames without a contact so far
    height: Out[Length] = port(truth="height")  # height of the object's top
    observed_top: Out[ObservedTop]  # the same, with how it was measured

    def update(self) -> Status:
        """Measure."""
        contact = self.contact
        # the scene knows the height of the top in the world alone
        self.untold = (
            frozenset() if contact is not None and self.frame.hand_height is not None else frozenset({"height"})
        )
        found = ObservedTop(*_both(self._risen()), 0.0, False) if contact is None else self._top(contact)
        # a difference of heights does not have this error, so that `observed_top` leaves it out
        level = self.pattern.hang_sd if contact is not None and self.pattern is not None else 0.0
        self.height, self.observed_top = Estimate(found.height, math.hypot(found.height_sd, level)), found
        return Status.SUCCESS

    def _risen(self) -> Estimate:
        rise = self.rise or Rise(0, perception.HeightTracker())
        tracker = deepcopy(rise.tracker)
        height = tracker.update(self.frame)
        self.rise = Rise(rise.frames + 1, tracker)
        return height

    def _top(self, contact: Contact) -> ObservedTop:
        frame, hand = self.frame, self.context.hand.geometry
        points, valid = perception.deproject(frame)
        points = perception.to_membrane(points, frame.plane_distance or 0.0)
        stretch, mounting = frame.stretch or 0.0, self.mounting
        top, by_membrane = height_of_top(hand, mounting, points, valid, contact.labels, stretch, self._curvature())
        off = 0.0
        if not by_membrane:
            off = camera_off(self.pattern, contact.surface, contact.labels, frame.plane_distance or 0.0)
            if self.sphere is None:
                top = as_touched(hand, mounting, top, contact.surface, contact.labels, stretch)
        return ObservedTop(top.value + (frame.hand_height or 0.0), math.hypot(top.sd, off), off, by_membrane)

    def _curvature(self) -> Estimate | None:
        return None if self.sphere is None else Estimate(self.sphere.curvature, self.sphere.curvature_sd)


def _both(height: Estimate) -> tuple[float, float]:
    return height.value, height.sd
