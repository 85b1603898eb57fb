"""Going back up to where the membrane has an equilibrium."""

from stretch_bt.behaviors._motion import MotionBehavior
from stretch_bt.behaviors.records import Touch
from stretch_bt.errors import NoEquilibrium
from stretch_bt.hardware.ages import FORCE, PRESSING_PLACE
from stretch_bt.hardware.interfaces import Arm, Motion
from stretch_bt.tree.ports import In, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Speed

BACK = 0.001  # m, rise at each step
CLEAR = 0.002  # m, height above first contact to which a hand close to it rises


@node
class RiseToBalance(MotionBehavior):
    """Raise the hand, a little at a time, to where the membrane has an equilibrium; from close to first contact, raise it clear."""

    arm: Uses[Arm]
    touch: In[Touch]  # first contact
    speed: In[Speed] = port(0.010, min=0.0005, max=0.050, doc="speed of the hand", limit="contact_speed")

    def start(self) -> Motion:
        """Go up a little."""
        pose = self.arm.pose(PRESSING_PLACE).value
        near = self.touch.height - pose.height <= 2 * BACK
        target = self.touch.height + CLEAR if near else pose.height + BACK
        return self.arm.move(pose.at_height(target), speed=self.speed, owner=self.path)

    def update(self) -> Status:
        """Go on; on the way the membrane need not have an equilibrium."""
        try:
            return super().update()
        except NoEquilibrium:
            return Status.RUNNING

    def arrived(self) -> Status:
        """Go on up while the arm finds no equilibrium; clear of first contact there is one."""
        try:
            self.arm.wrench(FORCE)
        except NoEquilibrium:
            if self.arm.pose(PRESSING_PLACE).value.height < self.touch.height + CLEAR / 2:
                self.motion = self.start()
                return Status.RUNNING
        return Status.SUCCESS
