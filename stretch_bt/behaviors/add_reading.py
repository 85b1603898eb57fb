"""Keeping the height of an object's top at a press."""

from stretch_bt.behaviors._readings import Reading, of_press, reading_sd
from stretch_bt.behaviors.records import ObservedTop, TopReadings, Touch
from stretch_bt.tree.ports import Behavior, In, InOut, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length

LEAST_SD = 1e-6  # m


@node
class AddReading(Behavior):
    """Add the height of the top at the present press to the readings since first contact.

    The membrane's depth is the hand's depth past first contact less the object's deflection, since that does not stretch the membrane.
    """

    kind = "perception"
    instant = True
    touch: In[Touch]  # first contact
    observed_top: In[ObservedTop]  # the top at this press, by `track_height`
    stretch: In[Length] = port(min=0.0, max=0.080, doc="stretch past the rest length")
    depth: In[Length] = port(doc="depth of the hand past first contact")
    frames: In[int] = port(8, min=1, max=256, doc="number of frames averaged for the height")
    frame_noise: In[Length] = port(
        0.0, min=0.0, max=0.01, doc="least standard deviation of a height's error in one frame, whatever it states"
    )
    rested: In[bool] = port(
        False, doc="whether to forget the earlier readings of this press: the object was left alone since then"
    )
    top_readings: InOut[TopReadings | None]  # all readings; they begin with this one where there are none

    def update(self) -> Status:
        """Add it."""
        seen = self.observed_top
        sd = max(reading_sd(seen.height_sd, self.frames, self.frame_noise), LEAST_SD)
        depth = self.depth - (self.touch.height - seen.height)
        reading = Reading(
            self.stretch, depth, seen.height, sd, frames=self.frames, fixed=seen.fixed_sd, by_membrane=seen.by_membrane
        )
        before = () if self.top_readings is None else self.top_readings.readings
        past = {id(old) for old in of_press(before, reading)} if self.rested else set()
        self.top_readings = TopReadings((*(old for old in before if id(old) not in past), reading))
        return Status.SUCCESS
