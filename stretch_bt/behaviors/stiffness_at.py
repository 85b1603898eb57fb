"""Stiffness at a stated deflection."""

from stretch_bt.behaviors.records import Felt
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length, Stiffness


@node
class StiffnessAt(Behavior):
    """Read the object's force over its deflection at a stated deflection off the curve that `fit_deflection` fitted.

    Soft objects stiffen as they give way, so that stiffnesses compare only at one deflection. FAILURE when its deflection is too small.
    """

    kind = "model"
    instant = True
    felt: In[Felt]  # the object
    deflection: In[Length] = port(0.0015, min=1e-4, doc="deflection at which the stiffness is wanted")
    stiffness: Out[Stiffness]  # force over deflection there

    def update(self) -> Status:
        """Read off the curve."""
        self.stiffness = self.felt.stiffness_at(self.deflection)
        return Status.SUCCESS
