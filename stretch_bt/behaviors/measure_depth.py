"""How deep the hand stands."""

from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.ages import PRESSING_PLACE
from stretch_bt.hardware.interfaces import Arm
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length


@node
class MeasureDepth(Behavior):
    """Measure how far the hand stands past first contact, 0 above it; its error is the first contact's, the same for all depths."""

    kind = "perception"
    instant = True
    arm: Uses[Arm]
    touch: In[Touch]  # first contact
    depth: Out[Length]  # depth of the hand

    def update(self) -> Status:
        """Measure."""
        depth = self.touch.height - self.arm.pose(PRESSING_PLACE).value.height
        self.depth = Estimate(max(depth, 0.0), self.touch.height_sd)
        return Status.SUCCESS
