"""The mean error of the diameters of a sensitivity map."""

from typing import Literal

from stretch_bt.behaviors.protocol_records import Table
from stretch_bt.model.calibration.sensitivity import Sensed
from stretch_bt.model.calibration.sensitivity_trends import mean_error
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length


@node
class MeanDiameterError(Behavior):
    """Compute the mean absolute error of diameters along i and j over a table's presses; FAILURE when all were refused."""

    kind = "model"
    instant = True
    measured: In[Table]  # the table, by `plan_protocol`
    method: In[Literal["fit", "paper_fit", "paper_width"]] = "fit"  # the way, as `compare_diameters` names it
    least_depth: In[Length] = port(5e-3, min=0.0, doc="least depth of the presses that count, at most the deepest")
    error: Out[Length]  # mean absolute error; presses that the method refused do not count

    def update(self) -> Status:
        """Average."""
        self.error = mean_error(self.measured.content.of(Sensed), self.method, self.least_depth)
        return Status.SUCCESS
