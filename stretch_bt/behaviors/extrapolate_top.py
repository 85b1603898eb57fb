"""The height of an undeformed top."""

import math

import numpy as np

from stretch_bt import model
from stretch_bt.behaviors._membrane import lift_at, strain_of
from stretch_bt.behaviors._motion import touched_at
from stretch_bt.behaviors._readings import Reading
from stretch_bt.behaviors.records import Mounting, TopReadings, Touch
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length


@node
class ExtrapolateTop(Behavior):
    """Extrapolate the heights of a top at shallow touches to its height at no force, from which `press` counts depths.

    The reading at a first touch is already low, because a soft object has deflected by then. The deflection is a power of the depth whose
    exponent follows from the membrane's tension and from the object's force law, for which the prior of any object is used.
    """

    kind = "model"
    instant = True
    top_readings: In[TopReadings]  # heights of the top at the touches
    pattern: In[Pattern | None] = None  # static error of the camera, as far as it was learned
    mounting: In[Mounting | None] = None  # mounting of the membrane, as far as it is known
    touch: Out[Touch]  # first contact
    contact_height: Out[Length] = port(truth="contact_height")  # height of first contact, world

    def update(self) -> Status:
        """Extrapolate."""
        readings = self.top_readings.readings
        lifts = [self._lift(reading) for reading in readings]
        heights = [reading.height - lift.value for reading, lift in zip(readings, lifts, strict=True)]
        depths, sds = [reading.depth for reading in readings], [reading.sd for reading in readings]
        strain = strain_of(self.context.hand.geometry.gauge, self.mounting, readings[-1].stretch if readings else 0.0)
        found = model.undeformed_height(depths, heights, sds, power=model.drop_power(strain, model.POWER))
        lifted = float(np.mean([lift.sd for lift in lifts]))  # all touches are of one top, so none averages it away
        sd = math.hypot(found.sd, lifted, self.pattern.hang_sd if self.pattern is not None else 0.0)
        self.touch, self.contact_height = Touch(found.value, sd), Estimate(found.value, sd)
        touched_at(self.context, self.touch)
        return Status.SUCCESS

    def _lift(self, reading: Reading) -> Estimate:
        """Return how far the membrane stands above the top at a touch, m: a flat top lifts it by its edges."""
        touch = reading.touch
        if touch is None:
            return Estimate(0.0, 0.0)
        hand = self.context.hand.geometry
        return lift_at(hand, self.mounting, reading.depth, touch.points, touch.labels, reading.stretch)
