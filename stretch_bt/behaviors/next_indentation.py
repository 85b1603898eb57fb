"""The depth at which to begin at the next stretch."""

from stretch_bt import model as mechanics
from stretch_bt.behaviors._models import ModelBehavior, inverted, within_range
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length


@node
class NextIndentation(ModelBehavior):
    """Find the depth of the membrane that gives the same force at another stretch, so that the force never falls."""

    radius: In[Length] = port(min=0.001, max=1.0, doc="radius of the sphere in contact")
    stretch: In[Length] = port(min=0.0, max=0.080, doc="next stretch")
    force: In[Force] = port(min=0.0, doc="force to be kept")
    depth: Out[Length]  # depth of the membrane, past first contact

    def update(self) -> Status:
        """Invert the force model."""
        model, radius, stretch = self.force_model(), self.radius, self.stretch
        with within_range():
            depth = mechanics.next_indentation(model, radius, stretch, self.force)
            self.depth = inverted(depth, lambda d: model.predict(radius, stretch, d))
        return Status.SUCCESS
