"""Pressing into the object."""

from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._limited_motion import LimitedMotion
from stretch_bt.behaviors._motion import MOST_DEPTH, touched_at
from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.ages import PRESSING_PLACE
from stretch_bt.hardware.interfaces import Arm, ForceSensor, Motion
from stretch_bt.tree.ports import In, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length, Speed


@node
class Press(LimitedMotion):
    """Move the hand to a depth past first contact, up or down; FAILURE when the force exceeds its limit.

    The arm's own force holds the limit; where that is too noisy for it, the force sensor does.
    """

    arm: Uses[Arm]
    force_sensor: Uses[ForceSensor | None]
    touch: In[Touch]  # first contact, from which depths count
    depth: In[Length] = port(min=0.0, max=MOST_DEPTH, doc="absolute depth past first contact", limit="depth")
    speed: In[Speed] = port(0.005, min=0.0005, max=0.050, doc="speed of the hand", limit="contact_speed")
    max_force: In[Force] = port(15.0, min=0.05, max=50.0, doc="force above which to stop and fail", limit="held_force")

    def start(self) -> Motion:
        """Move straight down, or up."""
        self.limit = ForceLimit(self.max_force, self.arm, self.force_sensor, self.context)
        pose, contact = self.arm.pose(PRESSING_PLACE).value, touched_at(self.context, self.touch)
        return self.arm.move(pose.at_height(contact - self.depth), speed=self.speed, owner=self.path)
