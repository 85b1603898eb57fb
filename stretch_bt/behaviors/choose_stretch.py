"""The stretch that gives a wanted force."""

from stretch_bt.behaviors._models import ModelBehavior, inverted, within_range
from stretch_bt.errors import NoAnswer
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length


@node
class ChooseStretch(ModelBehavior):
    """Find the stretch at which a depth gives the wanted force, or the nearest there is; FAILURE when none does and no nearest is wanted."""

    radius: In[Length] = port(min=0.001, max=1.0, doc="of the sphere in contact")
    depth: In[Length] = port(min=0.0, doc="of the membrane")
    force: In[Force] = port(min=0.0, doc="wanted")
    nearest: In[bool] = port(
        False, doc="whether the end of the range that comes nearest will do where no stretch gives it"
    )
    max_stretch: In[Length] = port(0.080, min=0.0, max=0.080, doc="the largest, taken where none is hard enough")
    stretch: Out[Length]  # that gives the force

    def update(self) -> Status:
        """Invert the force model."""
        try:
            self.stretch = self._inverted()
        except NoAnswer:
            if not self.nearest:
                raise
            self.stretch = 0.0 if self._is_soft() else self.max_stretch
        return Status.SUCCESS

    def _inverted(self) -> Estimate:
        model, radius, depth = self.force_model(), self.radius, self.depth
        with within_range():
            stretch = model.stretch_for(radius, depth, self.force)
            return inverted(stretch, lambda x: model.predict(radius, x, depth))

    def _is_soft(self) -> bool:
        """Return whether the slack membrane presses harder already."""
        try:
            with within_range():
                return self.force <= self.force_model().predict(self.radius, 0.0, max(self.depth, 0.0))[0]
        except NoAnswer:
            return False
