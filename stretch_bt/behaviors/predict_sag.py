"""Predicting how far the free membrane sags."""

from stretch_bt.behaviors._models import ModelBehavior, within_range
from stretch_bt.behaviors.records import Mounting
from stretch_bt.perception.pattern import HANG
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length


@node
class PredictSag(ModelBehavior):
    """Predict how far the free membrane sags in its middle by its own weight.

    `approach` needs it, since no camera tells a sag from a static error of its own of that shape. A model that knows nothing
    of the membrane's weight, as the paper's, or a membrane that is all but slack, gives what silicone membranes do, 0.3 +- 0.3 mm.
    """

    stretch: In[Length] = port(0.0, min=0.0, max=0.080, doc="past the rest length")
    mounting: Out[Mounting]  # of the membrane, with its sag

    def update(self) -> Status:
        """Predict."""
        with within_range():
            model = self.force_model()
            known = model.hang(self.stretch)
        sag = HANG if known is None else known
        self.mounting = Mounting(model.prestretch, sag.value, sag.sd)
        return Status.SUCCESS
