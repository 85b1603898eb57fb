"""Stiffness at a stated drop."""

from stretch_bt.behaviors._readings import fitted
from stretch_bt.errors import IllConditioned
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length, Stiffness


@node
class StiffnessAt(Behavior):
    """Tell the object's force over its drop at a stated drop, on the curve that `track_drop` fitted last.

    Soft objects stiffen as they give way, so that stiffnesses compare only at one drop. FAILURE when the object gave way by too little to tell.
    """

    kind = "model"
    instant = True
    drop: In[Length] = port(0.0015, min=1e-4, doc="at which to tell")
    stiffness: Out[Stiffness]  # force over drop there

    def update(self) -> Status:
        """Read off the curve."""
        found = fitted(self.context)
        if found is None:
            raise IllConditioned("nothing is known of the object yet; run 'track_drop' first")
        self.stiffness = found.series.stiffness_at(self.drop)
        return Status.SUCCESS
