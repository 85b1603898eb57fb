"""Detecting dough that came along with the hand."""

from stretch_bt import perception
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length

SURE = 3.0  # standard deviations


@node
class DetectAdhesion(Behavior):
    """Detect dough adhering to the raised membrane: compare its lowest point with the free membrane's.

    It takes a frame at the stretch of `approach`, with the camera's static error taken off.
    A lump of 20 g pulls a slack membrane of the shipped hand down by 3 mm, one stretched by 80 mm by 1 mm.
    """

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # frame of the raised hand
    pattern: In[Pattern]  # static error of the camera, with the sag of the free membrane
    least: In[Length] = port(0.0004, min=0.0, max=0.05, doc="least pull that counts, if it is significant")
    pulled: Out[Length]  # how far the membrane's lowest place lies below the free membrane's
    adhering: Out[bool]  # whether that is more than `least` and three standard deviations

    def update(self) -> Status:
        """Compare."""
        self.pulled = found = perception.pulled_down(self.frame, self.pattern)
        self.adhering = found.value > max(self.least, SURE * found.sd)
        return Status.SUCCESS
