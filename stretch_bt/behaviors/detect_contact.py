"""Detecting whether the membrane touches something."""

from copy import deepcopy

from stretch_bt import perception
from stretch_bt.behaviors.records import Watch
from stretch_bt.frames import DepthFrame
from stretch_bt.tree.ports import Behavior, In, InOut, Out, Status, port
from stretch_bt.tree.registry import node


@node
class DetectContact(Behavior):
    """Detect from frame to frame whether the membrane touches something; the first ten frames must be without contact."""

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # next frame; frames must come in order
    false_alarms: In[float] = port(
        1e-3, min=1e-9, max=0.1, doc="probability that a frame without contact counts as a touch"
    )
    watch: InOut[Watch | None]  # the membrane without contact, by the frames so far; it begins with the first frame
    in_contact: Out[bool]  # whether this frame shows a touch

    def update(self) -> Status:
        """Take the frame into account."""
        watch = self.watch or Watch(0, perception.ContactDetector(false_alarms=self.false_alarms))
        detector = deepcopy(watch.detector)
        self.in_contact = detector.update(self.frame)
        self.watch = Watch(watch.frames + 1, detector)
        return Status.SUCCESS
