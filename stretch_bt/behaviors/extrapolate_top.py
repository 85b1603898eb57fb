"""The height of an undeformed top."""

import math

from stretch_bt import model
from stretch_bt.behaviors._motion import touched_at
from stretch_bt.behaviors.records import TopReadings, Touch
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length

#: of the way from the highest reading to no force, by which it may be off: objects differ in their power
EXTRAPOLATED = 0.2


@node
class ExtrapolateTop(Behavior):
    """Extrapolate the heights of a top at shallow touches to its height at no force, from which `press` counts.

    The reading at a first touch is low already, because a soft object has given way by then.
    """

    kind = "model"
    instant = True
    top_readings: In[TopReadings]  # heights of the top at the touches
    pattern: In[Pattern | None] = None  # static error of the camera, as far as it was learned
    touch: Out[Touch]  # first contact
    contact_height: Out[Length] = port(truth="contact_height")  # its height, world

    def update(self) -> Status:
        """Extrapolate."""
        readings = self.top_readings.readings
        heights = [reading.height for reading in readings]
        depths, sds = [reading.depth for reading in readings], [reading.sd for reading in readings]
        found = model.undeformed_height(depths, heights, sds)
        beyond = EXTRAPOLATED * max(found.value - max(heights), 0.0)
        sd = math.hypot(found.sd, beyond, self.pattern.hang_sd if self.pattern is not None else 0.0)
        self.touch, self.contact_height = Touch(found.value, sd), Estimate(found.value, sd)
        touched_at(self.context, self.touch)
        return Status.SUCCESS
