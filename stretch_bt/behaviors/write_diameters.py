"""Writing down a press of a sensitivity map."""

from stretch_bt.behaviors._pressed import pressed
from stretch_bt.behaviors.protocol_records import Indenter, Table, Trial
from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.interfaces import Arm, Gripper
from stretch_bt.model.calibration.sensitivity import Found, Sensed
from stretch_bt.tree.ports import Behavior, In, InOut, Status, Uses
from stretch_bt.tree.registry import node


@node
class WriteDiameters(Behavior):
    """Add the diameters found of a flat cylinder to the table that `plan_protocol` opened, and return once the disk has it.

    Gripper and arm measure stretch and depth, which may differ from the commanded ones; the depth counts from the contact that
    `approach` found.
    """

    kind = "model"
    instant = True
    arm: Uses[Arm]
    gripper: Uses[Gripper]
    touch: In[Touch]  # first contact, from which depths count
    indenter: In[Indenter]  # mounted indenter
    trial: In[Trial]  # trial that this press belongs to
    found: In[tuple[Found, ...]]  # diameters, as `compare_diameters` gives them
    measured: InOut[Table]  # the table, with this press in it

    def update(self) -> Status:
        """Write."""
        content = self.measured.content
        content.of(Sensed)
        grown = content.grown(self._press())
        self.measured = Table(len(grown.presses), grown)
        return Status.SUCCESS

    def _press(self) -> Sensed:
        stretch, depth = pressed(self.context.hand.geometry, self.touch, self.arm, self.gripper)
        return Sensed(
            "cylinder", self.indenter.diameter, stretch, depth, self.trial.number, tuple(self.found), self.context.time
        )
