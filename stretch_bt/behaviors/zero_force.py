"""Zeroing the force sensor."""

from stretch_bt.behaviors._force import ForceMean
from stretch_bt.behaviors.records import Zero
from stretch_bt.hardware.interfaces import Arm, ForceSensor
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force


@node
class ZeroForce(Behavior):
    """Zero the force sensor, and measure its remaining offset, which `measure_force` takes off its forces.

    The hand must touch nothing; no reading shows whether it does.
    """

    kind = "actuation"
    force_sensor: Uses[ForceSensor]
    arm: Uses[Arm | None]
    count: In[int] = port(20, min=2, max=10000, doc="number of readings to average, one a tick")
    offset: Out[Force]  # remaining offset, which is taken off
    zero: Out[Zero]  # the same, with the readings

    def initialise(self) -> None:
        """Zero at the first tick."""
        self.readings: ForceMean | None = None

    def update(self) -> Status:
        """Zero, then collect."""
        if self.readings is None:
            self.force_sensor.zero()
            self.readings = ForceMean(self.context, self.force_sensor, self.arm)
        if self.readings.add() < self.count:
            return Status.RUNNING
        sample = self.readings.sample()
        self.offset = Estimate(sample.force, sample.force_sd)
        self.zero = Zero(sample.force, sample.force_sd, sample)
        return Status.SUCCESS
