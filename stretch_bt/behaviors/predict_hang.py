"""Predicting how far the free membrane hangs."""

from stretch_bt.behaviors._models import ModelBehavior, within_range
from stretch_bt.perception.pattern import HANG
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length


@node
class PredictHang(ModelBehavior):
    """Predict how far the free membrane hangs in its middle by its own weight.

    `approach` takes it, since no camera tells a hang from a static error of its own of that shape. A model that knows nothing
    of the membrane's weight, as the paper's, or a membrane that is all but slack, gives what silicone membranes do, 0.3 +- 0.3 mm.
    """

    stretch: In[Length] = port(0.0, min=0.0, max=0.080, doc="past the rest length")
    hang: Out[Length]  # of the middle, below the flat membrane
    mount_prestretch: Out[Length]  # of the membrane at stretch 0; 0 where the model does not know it

    def update(self) -> Status:
        """Predict."""
        with within_range():
            model = self.force_model()
            told = model.hang(self.stretch)
        self.mount_prestretch = model.prestretch
        self.hang = HANG if told is None else told
        return Status.SUCCESS
