"""Young's modulus of an elastic sphere."""

from stretch_bt import model as mechanics
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length, Pressure


@node
class EstimateModulus(Behavior):
    """Compute Young's modulus of the sphere in contact from force, deflection and both depths, by the paper's formula.

    It describes a solid sphere with the same force and deflection; a filled balloon has none. FAILURE when the deflection is too small.
    """

    kind = "model"
    instant = True
    force: In[Force] = port(min=0.0, doc="force at the present press")
    deflection: In[Length]  # deflection of the top
    depth: In[Length] = port(min=0.0, doc="membrane's depth: travel past first contact less the object's deflection")
    radius: In[Length] = port(min=0.001, max=1.0, doc="radius of the sphere in contact")
    force_sd: In[Force] = port(0.0, min=0.0, doc="standard deviation of force")
    deflection_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of deflection")
    depth_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of depth")
    radius_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of radius")
    poisson: In[float] = port(0.5, min=-0.99, max=0.5, doc="Poisson ratio of the sphere")
    modulus: Out[Pressure]  # Young's modulus

    def update(self) -> Status:
        """Compute it."""
        given = [
            Estimate(getattr(self, n), getattr(self, f"{n}_sd")) for n in ("force", "deflection", "depth", "radius")
        ]
        self.modulus = mechanics.object_modulus(*given, poisson=self.poisson)
        return Status.SUCCESS
