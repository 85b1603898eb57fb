"""Going back up to a light touch."""

from stretch_bt.behaviors._first_touch import top_of
from stretch_bt.behaviors._motion import MotionBehavior
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.ages import PRESSING_PLACE
from stretch_bt.hardware.interfaces import Arm, Motion
from stretch_bt.tree.ports import In, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length, Speed


@node
class RiseToTouch(MotionBehavior):
    """Raise the hand where contact was noticed late, so that the first touch is a light one, which shows most of the height at no force."""

    arm: Uses[Arm]
    frame: In[DepthFrame]  # frame of the contact
    deepest: In[Length] = port(0.0025, min=0.0005, max=0.010, doc="largest depth of the first touch")
    speed: In[Speed] = port(0.005, min=0.0005, max=0.050, doc="speed of the hand", limit="contact_speed")

    def initialise(self) -> None:
        """Look how deep the contact is."""
        super().initialise()
        found = top_of(self.frame, self.context.hand.geometry)
        self.rise = 0.0 if found is None else max(found[0].value - self.deepest, 0.0)

    def start(self) -> Motion:
        """Move straight up."""
        pose = self.arm.pose(PRESSING_PLACE).value
        return self.arm.move(pose.moved(z=self.rise), speed=self.speed, owner=self.path)

    def update(self) -> Status:
        """Rise, where there is need to."""
        return super().update() if self.rise > 0 else Status.SUCCESS
