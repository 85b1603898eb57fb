"""Writing down a press of a characterisation."""

from stretch_bt.behaviors._row import RowBehavior
from stretch_bt.model.calibration.characterization import PressRow
from stretch_bt.tree.ports import In, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force


@node
class WriteRow(RowBehavior):
    """Add the present press to the table that `plan_protocol` opened, and return once the disk has it."""

    row = PressRow
    force: In[Force]  # force at this press
    force_sd: In[Force] = port(0.0, min=0.0, doc="standard deviation of force")

    def press(self, stretch: float, depth: float) -> PressRow:
        """Return the present press."""
        indenter = self.indenter
        force, sd = float(self.force), float(self.force_sd)
        return PressRow(
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
