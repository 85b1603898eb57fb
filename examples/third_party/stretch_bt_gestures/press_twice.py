"""Pressing twice at one place."""

from stretch_bt import In, Status, Uses, node, port
from stretch_bt.behaviors import MotionBehavior
from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.interfaces import Arm, Motion
from stretch_bt.units import Length, Speed

MAX_AGE = 0.2  # s, of a pose


@node
class PressTwice(MotionBehavior):
    """Press to a depth, ease off and press again; FAILURE when a motion is blocked."""

    arm: Uses[Arm]
    touch: In[Touch]  # first contact, by `approach`
    depth: In[Length] = port(min=0.0, max=0.030, doc="absolute, past first contact", limit="depth")
    relief: In[Length] = port(0.002, min=0.0005, max=0.030, doc="how far the hand eases off between the two")
    speed: In[Speed] = port(0.005, min=0.0005, max=0.050, doc="of the hand", limit="contact_speed")

    def start(self) -> Motion:
        """Give the first of the three motions."""
        self.depths = [self.depth - self.relief, self.depth]
        return self.move_to(self.depth)

    def arrived(self) -> Status:
        """Give the next motion, until none is left."""
        if not self.depths:
            return Status.SUCCESS
        self.motion = self.move_to(self.depths.pop(0))
        return Status.RUNNING

    def move_to(self, depth: float) -> Motion:
        """Move straight up or down to a depth, m."""
        pose = self.arm.pose(MAX_AGE).value
        return self.arm.move(pose.at_height(self.touch.height - depth), speed=self.speed, owner=self.path)
