"""Tracking the height of the object's top."""

import math

from stretch_bt import perception
from stretch_bt.behaviors._membrane import as_touched, camera_off, height_of_top, keep_how
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.types import Contact, Sphere
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length


@node
class TrackHeight(Behavior):
    """Measure the height of the object's top through the membrane; FAILURE when nothing is in contact.

    With a contact the height is that of its top, and of the highest where there are several: in the world when the frame knows where the
    hand is, else above the flat membrane. Its deviation counts how many pixels share the camera's noise, and by how much the camera is off
    over all of the contact: what `approach` could not take off, or else what the undeformed membrane shows. Over a flat top the membrane
    stands a little higher, as its edges bend it; that is taken off.

    Without a contact it is how far the highest place has risen above the first frames, on any soft sensor.

    With a sphere, after an `approach` that was told how the membrane is mounted, the whole membrane tells the height, by the shape that the
    solved sheet has over such a sphere. The contact alone tells it where that shape does not fit.
    """

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # the one to measure in
    contact: In[Contact | None] = None  # where the top is; without it, frames are followed one by one
    sphere: In[Sphere | None] = None  # fitted to the top in contact before; with it the height is surer
    height: Out[Length] = port(truth="height")  # of the object's top

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self.tracker: perception.HeightTracker | None = None

    def update(self) -> Status:
        """Measure."""
        if self.contact is None:
            self.height = self._risen()
            keep_how(self.context, by_membrane=False)
        else:
            self.height = self._top(self.contact)
        return Status.SUCCESS

    def _risen(self) -> Estimate:
        if self.tracker is None:
            self.tracker = perception.HeightTracker()
        return self.tracker.update(self.frame)

    def _top(self, contact: Contact) -> Estimate:
        frame = self.frame
        points, valid = perception.deproject(frame)
        points = perception.to_membrane(points, frame.plane_distance or 0.0)
        top, by_membrane = height_of_top(
            self.context, points, valid, contact.labels, frame.stretch or 0.0, self._curvature()
        )
        keep_how(self.context, by_membrane=by_membrane)
        if not by_membrane:
            top = self._as_touched(top, contact, frame)
        return Estimate(top.value + (frame.hand_height or 0.0), top.sd)

    def _as_touched(self, top: Estimate, contact: Contact, frame: DepthFrame) -> Estimate:
        """Return the height of what is touched, as far as the contact tells it: a flat top lifts the membrane by its edges."""
        off = camera_off(self.context, contact.surface, contact.labels, frame.plane_distance or 0.0)
        if self.sphere is None:
            top = as_touched(self.context, top, contact.surface, contact.labels, frame.stretch or 0.0)
        return Estimate(top.value, math.hypot(top.sd, off))

    def _curvature(self) -> Estimate | None:
        return None if self.sphere is None else Estimate(self.sphere.curvature, self.sphere.curvature_sd)
