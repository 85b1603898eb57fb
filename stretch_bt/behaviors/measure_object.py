"""Measuring an object."""

from stretch_bt import perception
from stretch_bt.perception.clouds.cloud import Cloud
from stretch_bt.perception.clouds.dimensions import Dimensions
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length


@node
class MeasureObject(Behavior):
    """Measure the dimensions of an object between its faces; FAILURE when the cloud is too small or a line."""

    kind = "perception"
    instant = True
    cloud: In[Cloud]  # cloud of its surface
    dimensions: Out[Dimensions]  # lengths along three axes, and how each was measured
    length: Out[Length] = port(truth="length")  # the longer dimension across z
    width: Out[Length] = port(truth="width")  # the shorter dimension across z
    height: Out[Length] = port(truth="height")  # the dimension nearest to z

    def update(self) -> Status:
        """Measure."""
        found = perception.measure_object(self.cloud)
        self.dimensions = found
        self.length, self.width, self.height = (Estimate(v, sd) for v, sd in zip(found.lengths, found.sd, strict=True))
        return Status.SUCCESS
