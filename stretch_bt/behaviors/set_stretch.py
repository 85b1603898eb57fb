"""Stretching the membrane."""

from stretch_bt.behaviors._motion import MOST_STRETCH, MotionBehavior
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.interfaces import Gripper, Motion
from stretch_bt.tree.ports import In, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length, Speed

#: how far the fingers may stand from where they were sent, m: a little more than one count of the gripper
TOLERANCE = 0.001


@node
class SetStretch(MotionBehavior):
    """Open the gripper until the membrane has the wanted stretch; FAILURE when the fingers do not get there."""

    gripper: Uses[Gripper]
    stretch: In[Length] = port(min=0.0, max=MOST_STRETCH, doc="stretch past the rest length", limit="stretch")
    speed: In[Speed] = port(0.020, min=0.001, max=0.150, doc="speed of the fingers", limit="gripper_speed")

    def start(self) -> Motion:
        """Move the fingers."""
        return self.gripper.move(self.context.hand.geometry.opening(self.stretch), speed=self.speed, owner=self.path)

    def arrived(self) -> Status:
        """Believe the measured opening, not the report of success: the membrane pulls the fingers shut."""
        stretch = self.context.hand.geometry.stretch(self.gripper.opening(PLACE).value)
        if abs(stretch - self.stretch) <= TOLERANCE:
            return Status.SUCCESS
        self.reason = f"the fingers stand at a stretch of {stretch * 1e3:.1f} mm instead of {self.stretch * 1e3:.1f} mm"
        return Status.FAILURE
