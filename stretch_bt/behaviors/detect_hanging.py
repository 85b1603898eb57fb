"""Telling whether something came along with the hand."""

from stretch_bt import perception
from stretch_bt.errors import IllConditioned
from stretch_bt.frames import DepthFrame
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length

SURE = 3.0  # standard deviations


@node
class DetectHanging(Behavior):
    """Tell whether what sticks to the raised membrane pulls it down: its lowest place against where it hung before the first touch.

    It takes a frame at the stretch of `approach`, with the camera's static error taken off; FAILURE where `approach` learned none.
    A lump of 20 g pulls a slack membrane of the shipped hand down by 3 mm, one stretched by 80 mm by 1 mm.
    """

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # of the raised hand
    least: In[Length] = port(0.0004, min=0.0, max=0.05, doc="that counts as pulled, if it is sure")
    pulled: Out[Length]  # how far its lowest place lies below where it hung
    hanging: Out[bool]  # whether that is more than `least` and three standard deviations

    def update(self) -> Status:
        """Compare."""
        pattern = self.context.memory.get(perception.Pattern)
        if pattern is None:
            raise IllConditioned(
                "how the membrane hangs freely is not known: approach an object first, with learn_pattern"
            )
        self.pulled = found = perception.pulled_down(self.frame, pattern)
        self.hanging = found.value > max(self.least, SURE * found.sd)
        return Status.SUCCESS
