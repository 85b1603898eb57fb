"""Finding the contact in a frame."""

from typing import Literal

from stretch_bt import perception
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.registry import node


@node
class SegmentContact(Behavior):
    """Split the membrane into undeformed, deformed and in contact; FAILURE when nothing is in contact."""

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # frame with the hand's stretch, where it is known
    rule: In[Literal["mean", "either"]] = "mean"  # mean curvature, or the paper's convex along either axis
    pattern: In[Pattern | None] = None  # static error of the camera, as far as it was learned
    contact: Out[Contact]  # labels, points, rays and noise of the contact

    def update(self) -> Status:
        """Segment."""
        contact = perception.find_contact(self.frame, rule=self.rule)
        self.contact = contact if self.pattern is None else perception.with_left_over(contact, self.pattern)
        return Status.SUCCESS
