"""Stiffness from force and deflection."""

from stretch_bt import model as mechanics
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length, Stiffness


@node
class EstimateStiffness(Behavior):
    """Divide the force by the object's deflection; FAILURE when the deflection is too small for that."""

    kind = "model"
    instant = True
    force: In[Force] = port(min=0.0, doc="force at the present press")
    deflection: In[Length]  # deflection of the top
    force_sd: In[Force] = port(0.0, min=0.0, doc="standard deviation of force")
    deflection_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of deflection")
    correlation: In[float] = port(0.0, min=-1.0, max=1.0, doc="correlation of the errors of force and deflection")
    stiffness: Out[Stiffness] = port(truth="stiffness")  # force over deflection

    def update(self) -> Status:
        """Divide, with the standard deviations of both."""
        force, deflection = Estimate(self.force, self.force_sd), Estimate(self.deflection, self.deflection_sd)
        self.stiffness = mechanics.estimate_stiffness(force, deflection, self.correlation)
        return Status.SUCCESS
