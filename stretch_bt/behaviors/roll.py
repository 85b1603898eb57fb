"""Rolling what lies under the hand."""

import math

from stretch_bt.behaviors._motion import MotionBehavior
from stretch_bt.hardware.interfaces import Arm, Motion
from stretch_bt.tree.ports import In, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length, Speed

MAX_AGE = 0.5
STEPS = 72  # poses a turn: the chord misses the circle by a thousandth of the radius


@node
class Roll(MotionBehavior):
    """Press to a depth and move the hand once round a circle that begins and ends where it stands."""

    arm: Uses[Arm]
    radius: In[Length] = port(0.015, min=0.001, max=0.060, doc="of the circle")
    speed: In[Speed] = port(0.030, min=0.001, max=0.250, doc="along the circle")
    depth: In[Length] = port(0.005, min=0.0, max=0.030, doc="absolute, past first contact")

    def start(self) -> Motion:
        """Follow the circle."""
        contact = self.context.hand.touched_at
        start = self.arm.pose(MAX_AGE).value.at_height(contact - self.depth)
        angles = [2 * math.pi * k / STEPS for k in range(STEPS + 1)]
        path = [start.moved(x=self.radius * (math.cos(a) - 1), y=self.radius * math.sin(a)) for a in angles]
        return self.arm.follow(path, speed=self.speed, owner=self.path)
