"""The presses that may come next."""

from stretch_bt import model as mechanics
from stretch_bt.behaviors._models import ModelBehavior
from stretch_bt.behaviors._motion import lowest_of
from stretch_bt.behaviors.records import Candidates, Felt, Touch
from stretch_bt.model.palpation.planning import stretches
from stretch_bt.perception.types import Sphere
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length


@node
class ListPresses(ModelBehavior):
    """List the presses within the limits, at the present stretch and in steps up to the largest, with the forces that the model predicts."""

    touch: In[Touch]  # first contact, from which depths count
    sphere: In[Sphere]  # sphere in contact
    felt: In[Felt]  # the object, as far as it was felt, at the present press
    max_depth: In[Length] = port(0.018, min=0.001, max=0.030, doc="largest depth past first contact", limit="depth")
    max_force: In[Force] = port(8.0, min=0.05, max=50.0, doc="largest force, by the model", limit="force")
    max_stretch: In[Length] = port(0.080, min=0.0, max=0.080, doc="largest stretch of the membrane", limit="stretch")
    stretch_step: In[Length] = port(0.010, min=0.001, max=0.080, doc="step between the stretches to choose from")
    candidates: Out[Candidates]  # presses to choose from

    def prepare(self) -> None:
        """Load the model, and refuse one whose range ends below the planned stretch."""
        super().prepare()
        self.prepare_reach(lambda: self.max_stretch)

    def update(self) -> Status:
        """List them."""
        height = self.touch.height
        lowest = max(height - self.max_depth, lowest_of(self.context))
        limits = mechanics.Limits(lowest, self.max_force, self.max_stretch, self.stretch_step)
        count = len(stretches(self.felt.last.stretch, limits))
        self.candidates = Candidates(self.force_model(), self.sphere.radius, height, limits, count)
        return Status.SUCCESS
