"""Taking the hand to where the touched object stands in its middle."""

import numpy as np

from stretch_bt.behaviors._motion import MotionBehavior, slowed
from stretch_bt.errors import NoContact
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.interfaces import Arm, Motion
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import In, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length, Speed

#: the membrane frame's y is reversed against the hand's
MIRROR = np.array([1.0, -1.0])
HIGHEST = 0.99  # share of the points that lie lower: higher ones may be noise
TOP = 0.0015  # m


@node
class MoveOverContact(MotionBehavior):
    """Raise the hand clear and take it across to where the top of a contact was; FAILURE when the contact does not know its pose.

    The top is the middle of the points within 1.5 mm of the highest place: a tense membrane may look touched beside a clamp as well.
    It goes no faster than the cell allows where the hand may meet something.
    """

    arm: Uses[Arm]
    contact: In[Contact]  # last contact before the hand left
    clearance: In[Length] = port(0.010, min=0.0, max=0.300, doc="height above the present one", limit="travel")
    speed: In[Speed] = port(0.050, min=0.001, max=0.250, doc="speed of the hand", limit="speed")

    def start(self) -> Motion:
        """Go up, then across."""
        now, seen = self.arm.pose(PLACE).value, self.contact
        if seen.pose is None or not len(seen.points):
            raise NoContact(
                "the contact does not know the pose of the hand, or has no point; use an arm beside the camera"
            )
        high = seen.points[:, 2]
        top = seen.points[high >= np.quantile(high, HIGHEST) - TOP]
        matrix, middle = seen.pose.matrix()[:2, :2], np.median(top[:, :2], axis=0) * MIRROR
        x, y = (np.asarray(seen.pose.position[:2]) + matrix @ middle).tolist()
        raised = now.moved(z=self.clearance)
        across = raised.moved(x - now.position[0], y - now.position[1])
        path = [raised, across] if self.clearance > 0 else [across]
        return self.arm.follow(path, speed=slowed(self.context, self.speed, [now, *path]), owner=self.path)
