"""Having the operator agree."""

from stretch_bt.behaviors._motion import MotionBehavior
from stretch_bt.hardware.interfaces import Motion, Operator
from stretch_bt.tree.ports import In, Uses
from stretch_bt.tree.registry import node


@node
class Confirm(MotionBehavior):
    """Show the operator the next step, and wait until it is confirmed."""

    operator: Uses[Operator]
    request: In[str]  # text that says what the robot is about to do

    def start(self) -> Motion:
        """Ask."""
        return self.operator.confirm(self.request, owner=self.path)
