"""Counting depths from the highest place that was felt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stretch_bt.behaviors._motion import touched_at
from stretch_bt.behaviors.records import Touch
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.tree.ports import Behavior, In, InOut, Status
from stretch_bt.tree.registry import node

HIGHEST = 99.0  # per cent of the map that lie lower: higher places may be noise


@node
class RaiseTouch(Behavior):
    """Raise the height of first contact to the highest place that was felt since, so that no depth counts from below it."""

    kind = "perception"
    instant = True
    relief: In[Relief]  # map of the presses
    touch: InOut[Touch]  # first contact

    def update(self) -> Status:
        """Raise it."""
        top = self.relief.height[self.relief.felt]
        if top.size:
            self.touch = replace(self.touch, height=max(self.touch.height, float(np.percentile(top, HIGHEST))))
        touched_at(self.context, self.touch)
        return Status.SUCCESS
