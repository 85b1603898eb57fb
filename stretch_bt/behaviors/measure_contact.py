"""Measuring the object in contact."""

from stretch_bt.behaviors._size import Skirt, Wanted, measured
from stretch_bt.perception.size.result import ContactSize
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length


@node
class MeasureContact(Behavior):
    """Measure a flat-faced object in contact by its face and the skirt around it; FAILURE when the frame determines no size."""

    kind = "perception"
    instant = True
    contact: In[Contact]  # surface and labels of the contact, and its stretch where that is known
    hypothesis: In[Wanted] = port("auto", doc="shape; auto takes the simplest that no other clearly beats")
    fillet: In[Length] = port(1e-3, min=0.0, doc="radius of the object's edge, which no frame shows")
    fillet_sd: In[Length] = port(
        0.58e-3, min=0.0, doc="standard deviation of fillet; by default for any radius from 0 to 2 mm"
    )
    skirt: In[Skirt] = "thin"  # skirt of a sheet that does not resist bending, or of one that does
    mount_prestretch: In[Length] = port(
        0.0, min=0.0, max=0.05, doc="prestretch of the membrane by its mounts, at stretch 0"
    )
    diameter_i: Out[Length]  # width of the object across the stretch
    diameter_j: Out[Length]  # width of the object along the stretch
    size: Out[ContactSize]  # shape, sides, rotation, place and all else that the measurement finds

    def update(self) -> Status:
        """Measure."""
        size = measured(
            self.contact,
            hypothesis=self.hypothesis,
            skirt=self.skirt,
            mount_prestretch=self.mount_prestretch,
            fillet=self.fillet,
            fillet_sd=self.fillet_sd,
        )
        self.diameter_i = Estimate(size.diameter_i, size.diameter_i_sd)
        self.diameter_j = Estimate(size.diameter_j, size.diameter_j_sd)
        self.size = size
        return Status.SUCCESS
