"""Writing down a press of a characterisation."""

from stretch_bt.behaviors._pressed import pressed
from stretch_bt.behaviors._table import table_of
from stretch_bt.hardware.interfaces import Arm, Gripper
from stretch_bt.model.calibration.characterization import Press
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Angle, Force, Length


@node
class WriteRow(Behavior):
    """Add the present press to the table that `next_state` opened, and return once the disk has it.

    Stretch and depth are those that gripper and arm tell, not those that were asked for; the depth counts from the contact that
    `approach` found.
    """

    kind = "model"
    instant = True
    arm: Uses[Arm]
    gripper: Uses[Gripper]
    geometry: In[str]  # of what is mounted: sphere, cylinder or cone
    diameter: In[Length] = port(0.0, min=0.0, doc="of a sphere or cylinder")
    angle: In[Angle] = port(0.0, min=0.0, doc="of a cone, between its surface and the membrane plane")
    trial: In[int] = port(1, min=1, doc="from 1")
    force: In[Force]  # at this press
    force_sd: In[Force] = port(0.0, min=0.0, doc="standard deviation of force")
    table: In[str] = ""  # as `next_state` has it
    rows: Out[int]  # that the table holds now

    def update(self) -> Status:
        """Write."""
        press, table = self._press(), table_of(self.context, self.table)
        table.append(press)
        self.rows = len(table.presses)
        return Status.SUCCESS

    def _press(self) -> Press:
        stretch, depth = pressed(self.context.hand, self.arm, self.gripper)
        size = self.angle if self.geometry == "cone" else self.diameter
        force, sd = float(self.force), float(self.force_sd)
        where = self.context.hand.touched_at
        return Press(self.geometry, size, stretch, depth, self.trial, force, sd, where, self.context.time)
