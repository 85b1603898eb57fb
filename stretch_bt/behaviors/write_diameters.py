"""Writing down a press of a sensitivity map."""

from stretch_bt.behaviors._row import RowBehavior
from stretch_bt.model.calibration.sensitivity import Found, Sensed
from stretch_bt.tree.ports import In
from stretch_bt.tree.registry import node


@node
class WriteDiameters(RowBehavior):
    """Add the diameters found of a flat cylinder to the table that `plan_protocol` opened, and return once the disk has it."""

    row = Sensed
    found: In[tuple[Found, ...]]  # diameters, as `compare_diameters` gives them

    def press(self, stretch: float, depth: float) -> Sensed:
        """Return the present press."""
        return Sensed(
            "cylinder", self.indenter.diameter, stretch, depth, self.trial.number, tuple(self.found), self.context.time
        )
