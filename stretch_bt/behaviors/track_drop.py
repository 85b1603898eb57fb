"""Telling how far the object has given way, from all presses together."""

import math

from stretch_bt import model as mechanics
from stretch_bt.behaviors._models import ModelBehavior, within_range
from stretch_bt.behaviors._readings import Reading, readings_of
from stretch_bt.errors import IllConditioned
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length

LEAST_FORCE = 0.01  # share of the present force below which a reading says nothing of how forces compare


@node
class TrackDrop(ModelBehavior):
    """Tell how far the object's top has dropped at the present press, from this reading and those before it.

    Readings are those that `approach` took at the first touch and one from each time that this node runs. The force model
    says how the force grew from one to the next; the curve of height over force gives the height at no force, which no
    reading shows, and evens out the noise of single ones. A factor that the model is wrong by does not matter. Without
    readings by `approach` the drop is `contact_height` less this height.
    """

    radius: In[Length] = port(min=0.001, max=1.0, doc="of the sphere in contact")
    stretch: In[Length] = port(min=0.0, max=0.080, doc="past the rest length")
    depth: In[Length] = port(
        doc="of the membrane at this press: travel past first contact less what the object gave way"
    )
    height: In[Length] = port(doc="of the top at this press, as measured")
    height_sd: In[Length] = port(1e-4, min=0.0, doc="standard deviation of height")
    contact_height: In[Length] = port(doc="of the undeformed top, as `approach` found it")
    contact_height_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of contact_height")
    top: Out[Length]  # height of the undeformed top
    settled: Out[Length]  # height of the top at this press, on the curve
    drop: Out[Length]  # how far the top has given way, on the curve

    def update(self) -> Status:
        """Add this reading and fit all."""
        readings = readings_of(self.context)
        if not readings:
            top, height = Estimate(self.contact_height, self.contact_height_sd), Estimate(self.height, self.height_sd)
            self.top, self.settled = top, height
            self.drop = Estimate(top.value - height.value, math.hypot(top.sd, height.sd))
            return Status.SUCCESS
        readings.append(Reading(self.stretch, self.depth, self.height, self.height_sd))
        fit = mechanics.fit_yielding(*zip(*self._used(readings), strict=True))
        self.top, self.settled, self.drop = fit.top, fit.height, fit.drop
        return Status.SUCCESS

    def _used(self, readings: list[Reading]) -> list[tuple[float, float, float]]:
        """Return force, height and its standard deviation of the readings at a force that counts."""
        model, radius = self.force_model(), self.radius
        with within_range():
            forces = [model.predict(radius, r.stretch, max(r.depth, 0.0))[0] for r in readings]
        least = max(LEAST_FORCE * forces[-1], 1e-6)
        if forces[-1] <= least:
            raise IllConditioned("the hand is not past the undeformed top, so that this press says nothing of a drop")
        return [(f, r.height, max(r.sd, 1e-6)) for f, r in zip(forces, readings, strict=True) if f > least]
