"""Reading the height of a top that is barely touched."""

from stretch_bt.behaviors._first_touch import top_of
from stretch_bt.behaviors._readings import Reading
from stretch_bt.behaviors.records import TopReadings
from stretch_bt.frames import DepthFrame
from stretch_bt.tree.ports import Behavior, In, InOut, Status, port
from stretch_bt.tree.registry import node


@node
class ReadFirstTouch(Behavior):
    """Add the height of a top that is barely touched to the readings; a touch too light to be seen adds nothing.

    The points seen are kept with the height, so that `fit_deflection` can infer it again once the curvature of the top is known.
    """

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # frame of a shallow press
    frames: In[int] = port(8, min=1, max=256, doc="number of frames averaged for the height")
    top_readings: InOut[TopReadings | None]  # heights of the top since first contact

    def update(self) -> Status:
        """Read it."""
        frame, known = self.frame, self.top_readings or TopReadings()
        found = top_of(frame, self.context.hand.geometry)
        if found is None or found[0].value <= 0:
            self.top_readings = known
            return Status.SUCCESS
        top, touch = found
        height = top.value + (frame.hand_height or 0.0)
        reading = Reading(frame.stretch or 0.0, top.value, height, top.sd, touch, self.frames)
        self.top_readings = TopReadings((*known.readings, reading))
        return Status.SUCCESS
