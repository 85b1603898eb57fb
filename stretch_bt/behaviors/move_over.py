"""Taking the hand to another place above the object."""

from __future__ import annotations

import math

from stretch_bt.behaviors._motion import MotionBehavior, slowed
from stretch_bt.behaviors.records import Touch
from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Pose
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.interfaces import Arm, Motion
from stretch_bt.perception.clouds.seen import turn_of
from stretch_bt.tree.ports import In, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Angle, Length, Speed

STRAIGHT = 1e-6  # largest 1 - cosine of the hand's tilt that still counts as upright


@node
class MoveOver(MotionBehavior):
    """Raise the hand above all that was felt, take it across and turn it; it never moves across below that height.

    Before anything was felt it goes across where it stands. The limits of the cell bound where it may go: a place outside them
    is FAILURE before the hand moves. It goes no faster than the cell allows where the hand may meet something.
    """

    arm: Uses[Arm]
    touch: In[Touch | None] = None  # first contact, at the highest place that was felt, where it is known
    x: In[Length] = port(limit="x")  # x of the hand, world
    y: In[Length] = port(limit="y")  # y of the hand, world
    yaw: In[Angle] = port(0.0, min=-math.pi, max=math.pi, doc="turn about the vertical")
    clearance: In[Length] = port(
        0.020, min=0.005, max=0.300, doc="height above the highest place that was felt", limit="travel"
    )
    speed: In[Speed] = port(0.100, min=0.001, max=0.250, doc="speed of the hand", limit="speed")

    def start(self) -> Motion:
        """Go up, then across."""
        now = self.arm.pose(PLACE).value
        if now.matrix()[2, 2] < 1.0 - STRAIGHT:
            raise InvalidInput("the hand is tilted; 'move_over' turns only a hand that points straight down")
        contact = None if self.touch is None else self.touch.height
        high = now.height if contact is None else max(now.height, contact + self.clearance)
        across = Pose((self.x, self.y, high), (0.0, 0.0, self._turn(now)))
        raised = now.at_height(high)
        path = [across] if high - now.height < 1e-4 else [raised, across]
        return self.arm.follow(path, speed=slowed(self.context, self.speed, [now, *path]), owner=self.path)

    def _turn(self, now: Pose) -> float:
        """Return the wanted turn, or the half turn from it that is nearer: the membrane is the same."""
        have = turn_of(now)
        return self.yaw + math.pi * round((have - self.yaw) / math.pi)
