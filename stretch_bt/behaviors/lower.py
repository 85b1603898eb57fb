"""Lowering the hand by a step."""

from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._limited_motion import LimitedMotion
from stretch_bt.hardware.ages import PRESSING_PLACE
from stretch_bt.hardware.interfaces import Arm, ForceSensor, Motion
from stretch_bt.tree.ports import In, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length, Speed


@node
class Lower(LimitedMotion):
    """Lower the hand by a step, wherever first contact is; FAILURE when the force exceeds its limit."""

    arm: Uses[Arm]
    force_sensor: Uses[ForceSensor | None]
    by: In[Length] = port(0.001, min=0.0001, max=0.010, doc="step, straight down")
    speed: In[Speed] = port(0.005, min=0.0005, max=0.050, doc="speed of the hand", limit="contact_speed")
    max_force: In[Force] = port(5.0, min=0.05, max=50.0, doc="force above which to stop and fail", limit="held_force")

    def start(self) -> Motion:
        """Move straight down."""
        self.limit = ForceLimit(self.max_force, self.arm, self.force_sensor, self.context)
        pose = self.arm.pose(PRESSING_PLACE).value
        return self.arm.move(pose.moved(z=-self.by), speed=self.speed, owner=self.path)
