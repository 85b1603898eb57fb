"""Learning the static error of the camera."""

from dataclasses import replace

from stretch_bt.behaviors.records import FreeMembrane, Mounting
from stretch_bt.perception.pattern import HANG, Pattern
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate


@node
class LearnPattern(Behavior):
    """Learn the static error of the camera from frames of the free membrane, whose shape is known.

    A membrane in tension is flat but for its sag; the residual of the frames is the camera's own error. It is `none` where the frames
    do not show it. The sag cannot be distinguished from an error of the same shape, so `mounting` helps.
    """

    kind = "perception"
    instant = True
    free_membrane: In[FreeMembrane]  # frames of the free membrane, by `descend`
    mounting: In[Mounting | None] = None  # mounting of the membrane, as far as it is known
    pattern: Out[Pattern | None]  # static error of the camera, which `capture` and `average_frames` take off

    def update(self) -> Status:
        """Learn it."""
        free, hand = self.free_membrane, self.context.hand.geometry
        known = self.mounting or Mounting(0.0, HANG.value, HANG.sd)
        found = free.view.pattern(hand.gauge + known.prestretch, Estimate(known.sag, known.sag_sd), hand.width)
        self.pattern = None if found is None else replace(found, camera=free.camera)
        return Status.SUCCESS
