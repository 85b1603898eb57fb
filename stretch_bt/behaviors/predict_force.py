"""Predicting the contact force from what the camera sees."""

import math

from stretch_bt.behaviors._models import PAPER, force_model, within_range
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length


@node
class PredictForce(Behavior):
    """Predict the contact force of a sphere from its radius, the stretch and the depth of the membrane."""

    kind = "model"
    instant = True
    radius: In[Length] = port(min=0.001, max=1.0, doc="of the sphere in contact")
    stretch: In[Length] = port(min=0.0, max=0.080, doc="past the rest length")
    depth: In[Length] = port(
        doc="of the membrane: travel past first contact less what the object gave way; below 0 counts as 0"
    )
    radius_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of radius")
    depth_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of depth")
    model: In[str] = PAPER  # 'paper' for the shipped calibration, or the path of a calibration file
    force: Out[Force]  # on the object

    def update(self) -> Status:
        """Predict, with the standard deviations of model, radius and depth together."""
        with within_range():
            self.force = self._predict()
        return Status.SUCCESS

    def _predict(self) -> Estimate:
        model, depth = force_model(self.model), max(self.depth, 0.0)
        force, sd = model.predict(self.radius, self.stretch, depth)
        terms = [sd]
        if self.radius_sd > 0:
            terms.append(abs(model.predict(self.radius - self.radius_sd, self.stretch, depth)[0] - force))
        if self.depth_sd > 0:
            terms.append(abs(model.predict(self.radius, self.stretch, depth + self.depth_sd)[0] - force))
        return Estimate(force, math.hypot(*terms))
