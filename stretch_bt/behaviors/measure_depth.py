"""How deep the hand stands."""

from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.interfaces import Arm
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses
from stretch_bt.tree.registry import node
from stretch_bt.units import Length

MAX_AGE = 0.2


@node
class MeasureDepth(Behavior):
    """Measure the depth of the hand past first contact; above first contact it is 0."""

    kind = "perception"
    instant = True
    arm: Uses[Arm]
    touch: In[Touch]  # first contact
    depth: Out[Length]  # depth of the hand

    def update(self) -> Status:
        """Measure."""
        self.depth = max(self.touch.height - self.arm.pose(MAX_AGE).value.height, 0.0)
        return Status.SUCCESS
