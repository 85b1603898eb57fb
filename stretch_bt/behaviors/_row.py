"""The common part of nodes that write a press into the table of a protocol."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from stretch_bt.behaviors.protocol_records import Indenter, Table, Trial
from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.interfaces import Arm, Gripper
from stretch_bt.model.calibration.protocol import State
from stretch_bt.tree.ports import Behavior, In, InOut, Status, Uses

__all__ = ["RowBehavior"]


class RowBehavior(Behavior):
    """A node that adds the present press to a table, and returns once the disk has it.

    Gripper and arm measure stretch and depth, which may differ from the commanded ones; the depth counts from the contact that
    `approach` found.
    """

    kind = "model"
    instant: ClassVar[bool] = True
    #: class of the presses in the table
    row: ClassVar[type[State]]

    arm: Uses[Arm]
    gripper: Uses[Gripper]
    touch: In[Touch]  # first contact, from which depths count
    indenter: In[Indenter]  # mounted indenter
    trial: In[Trial]  # trial that this press belongs to
    measured: InOut[Table]  # the table, with this press in it

    @abstractmethod
    def press(self, stretch: float, depth: float) -> State:
        """Return the present press at a stretch and a depth past first contact, m."""

    def update(self) -> Status:
        """Write."""
        content = self.measured.content
        content.of(self.row)
        depth = self.touch.height - self.arm.pose(PLACE).value.height
        stretch = self.context.hand.geometry.stretch(self.gripper.opening(PLACE).value)
        grown = content.grown(self.press(stretch, depth))
        self.measured = Table(len(grown.presses), grown)
        return Status.SUCCESS
