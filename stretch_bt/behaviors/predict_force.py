"""Predicting the contact force from the camera's view."""

import math

from stretch_bt.behaviors._models import ModelBehavior, within_range
from stretch_bt.model import ForceModel
from stretch_bt.model.force.force_model import change_by_size
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length


@node
class PredictForce(ModelBehavior):
    """Predict the contact force of a sphere from its radius, the stretch and the depth of the membrane."""

    radius: In[Length] = port(min=0.001, max=1.0, doc="radius of the sphere in contact")
    stretch: In[Length] = port(min=0.0, max=0.080, doc="stretch past the rest length")
    depth: In[Length] = port(
        doc="depth of the membrane: travel past first contact less the object's deflection; below 0 counts as 0"
    )
    radius_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of radius")
    depth_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of depth")
    force: Out[Force]  # force on the object

    def update(self) -> Status:
        """Predict, with the standard deviations of model, radius and depth together."""
        model = self.force_model()
        with within_range():
            self.force = self._predict(model)
        return Status.SUCCESS

    def _predict(self, model: ForceModel) -> Estimate:
        depth = max(self.depth, 0.0)
        force, sd = model.predict(self.radius, self.stretch, depth)
        terms = [sd]
        if self.radius_sd > 0:
            terms.append(change_by_size(model, Estimate(self.radius, self.radius_sd), self.stretch, depth))
        if self.depth_sd > 0:
            terms.append(abs(model.predict(self.radius, self.stretch, max(depth - self.depth_sd, 0.0))[0] - force))
        return Estimate(force, math.hypot(*terms))
