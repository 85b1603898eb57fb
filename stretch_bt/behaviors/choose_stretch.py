"""The stretch that gives a wanted force."""

from stretch_bt.behaviors._models import ModelBehavior, inverted, within_range
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length


@node
class ChooseStretch(ModelBehavior):
    """Find the stretch at which a depth gives the wanted force; FAILURE when none does."""

    radius: In[Length] = port(min=0.001, max=1.0, doc="of the sphere in contact")
    depth: In[Length] = port(min=0.0, doc="of the membrane")
    force: In[Force] = port(min=0.0, doc="wanted")
    stretch: Out[Length]  # that gives the force

    def update(self) -> Status:
        """Invert the force model."""
        model, radius, depth = self.force_model(), self.radius, self.depth
        with within_range():
            stretch = model.stretch_for(radius, depth, self.force)
            self.stretch = inverted(stretch, lambda x: model.predict(radius, x, depth))
        return Status.SUCCESS
