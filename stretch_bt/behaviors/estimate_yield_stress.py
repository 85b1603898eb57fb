"""Yield stress of a plastic cube."""

from stretch_bt import model as mechanics
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length, Pressure


@node
class EstimateYieldStress(Behavior):
    """Compute the yield stress of a plastic cube from the force under which its top flows, and the height that it has then.

    The force counts where it no longer rises as the cube is pressed further. FAILURE when it is too small, or the cube lost
    less than a fiftieth or more than two fifths of its height.
    """

    kind = "model"
    instant = True
    force: In[Force] = port(min=0.0, doc="force under which the top flows")
    edge: In[Length] = port(min=0.001, max=1.0, doc="the cube's height before it was pressed")
    height: In[Length] = port(min=0.0, max=1.0, doc="height of its top under that force")
    force_sd: In[Force] = port(0.0, min=0.0, doc="standard deviation of force")
    edge_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of edge")
    height_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of height")
    density: In[float] = port(1250.0, min=1.0, max=25000.0, doc="density, kg/m^3")
    yield_stress: Out[Pressure] = port(truth="yield_stress")  # yield stress in compression

    def update(self) -> Status:
        """Compute it."""
        force, edge = Estimate(self.force, self.force_sd), Estimate(self.edge, self.edge_sd)
        height = Estimate(self.height, self.height_sd)
        self.yield_stress = mechanics.cube_yield_stress(force, edge, height, density=self.density)
        return Status.SUCCESS
