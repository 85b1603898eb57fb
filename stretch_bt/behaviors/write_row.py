"""Writing down a press of a characterisation."""

from stretch_bt.behaviors._pressed import pressed
from stretch_bt.behaviors.protocol_records import Indenter, Table, Trial
from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.interfaces import Arm, Gripper
from stretch_bt.model.calibration.characterization import Press
from stretch_bt.tree.ports import Behavior, In, InOut, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force


@node
class WriteRow(Behavior):
    """Add the present press to the table that `plan_protocol` opened, and return once the disk has it.

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
    force: In[Force]  # force at this press
    force_sd: In[Force] = port(0.0, min=0.0, doc="standard deviation of force")
    measured: InOut[Table]  # the table, with this press in it

    def update(self) -> Status:
        """Write."""
        content = self.measured.content
        content.of(Press)
        grown = content.grown(self._press())
        self.measured = Table(len(grown.presses), grown)
        return Status.SUCCESS

    def _press(self) -> Press:
        stretch, depth = pressed(self.context.hand.geometry, self.touch, self.arm, self.gripper)
        indenter = self.indenter
        force, sd = float(self.force), float(self.force_sd)
        return Press(
            indenter.geometry,
            indenter.size,
            stretch,
            depth,
            self.trial.number,
            force,
            sd,
            self.touch.height,
            self.context.time,
        )
