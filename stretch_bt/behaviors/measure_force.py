"""Measuring the contact force."""

import math

from stretch_bt.behaviors._force import ForceMean, check_alive
from stretch_bt.behaviors.records import ForceSample, Touch, Zero
from stretch_bt.hardware.interfaces import Arm, ForceSensor
from stretch_bt.tree.ports import Behavior, In, InOut, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force


@node
class MeasureForce(Behavior):
    """Take the mean of the next readings of the force sensor while the hand stands still; FAILURE when the sensor is stuck.

    The force is its component along the hand's axis, above 0 where the object pushes the hand away: noise does not raise it as it
    raises a magnitude. Its standard deviation combines the standard errors of the readings and of the last `zero_force`. A sensor is
    stuck when it has no new reading for a second, or when all its readings are alike to the last digit and equal the readings of
    the measurement before, at another depth of the hand. Without an arm the hand is taken to point straight down.
    """

    kind = "perception"
    force_sensor: Uses[ForceSensor]
    arm: Uses[Arm | None]
    count: In[int] = port(10, min=2, max=10000, doc="number of readings to average, one a tick")
    zero: In[Zero | None] = None  # reading of the sensor without a load, which is taken off
    touch: In[Touch | None] = None  # first contact: below it two measurements are never alike
    force_sample: InOut[ForceSample | None]  # readings of this measurement, and before it of the previous one
    force: Out[Force] = port(truth="force")  # force on the hand, along its axis

    def initialise(self) -> None:
        """Accept readings from now on."""
        self.readings = ForceMean(self.context, self.force_sensor, self.arm)

    def update(self) -> Status:
        """Collect, then average."""
        if self.readings.add() < self.count:
            return Status.RUNNING
        found, zero = self.readings.sample(), self.zero
        before = (self.force_sample, None if zero is None else zero.sample)
        self.force_sample = found
        check_alive(found, before, self.touch)
        offset, sd = (0.0, 0.0) if zero is None else (zero.offset, zero.offset_sd)
        self.force = Estimate(found.force - offset, math.hypot(found.force_sd, sd))
        return Status.SUCCESS
