"""Telling whether the membrane touches something."""

from stretch_bt import perception
from stretch_bt.frames import DepthFrame
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node


@node
class DetectContact(Behavior):
    """Tell from frame to frame whether the membrane touches something; the first ten frames must be without contact."""

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # the next one; frames must come in order
    false_alarms: In[float] = port(
        1e-3, min=1e-9, max=0.1, doc="probability that a frame without contact counts as one"
    )
    in_contact: Out[bool]  # whether this frame shows a touch

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self.detector: perception.ContactDetector | None = None

    def update(self) -> Status:
        """Take the frame into account."""
        if self.detector is None:
            self.detector = perception.ContactDetector(false_alarms=self.false_alarms)
        self.in_contact = self.detector.update(self.frame)
        return Status.SUCCESS
