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

    `approach` needs it, since no camera distinguishes a sag from a static error of its own of that shape. A model without the
    membrane's weight, such as the paper's, or a membrane that is all but slack, gives the sag usual of silicone membranes, 0.3 +- 0.3 mm.
    """

    stretch: In[Length] = port(0.0, min=0.0, max=0.080, doc="stretch past the rest length")
    mounting: Out[Mounting]  # mounting of the membrane, with its sag

    def update(self) -> Status:
        """Predict."""
        with within_range():
            model = self.force_model()
            known = model.hang(self.stretch)
        sag = HANG if known is None else known
        self.mounting = Mounting(model.prestretch, sag.value, sag.sd)
        return Status.SUCCESS
