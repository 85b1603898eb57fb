"""Leaving the object."""

import math

from stretch_bt.behaviors._motion import MotionBehavior, slowed
from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.interfaces import Arm, Motion
from stretch_bt.tree.ports import In, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length, Speed


@node
class Retract(MotionBehavior):
    """Raise the hand clear of the object: above first contact, or above where it is when none is known; never lower it.

    It goes no higher than the cell allows, and no faster where the hand may meet something.
    """

    arm: Uses[Arm]
    touch: In[Touch | None] = None  # first contact, where it is known
    clearance: In[Length] = port(0.020, min=0.0, max=0.300, doc="height above first contact")
    speed: In[Speed] = port(0.020, min=0.001, max=0.250, doc="speed of the hand", limit="speed")

    def start(self) -> Motion:
        """Move straight up."""
        pose = self.arm.pose(PLACE).value
        contact = None if self.touch is None else self.touch.height
        limits = self.context.limits
        highest = math.inf if limits is None else limits.height.max
        target = max(min((pose.height if contact is None else contact) + self.clearance, highest), pose.height)
        goal = pose.at_height(target)
        return self.arm.move(goal, speed=slowed(self.context, self.speed, [pose, goal]), owner=self.path)
