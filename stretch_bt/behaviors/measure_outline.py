"""Measuring the outline of a flat object."""

from typing import Literal

from stretch_bt import perception
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.registry import node
from stretch_bt.units import Area, Estimate, Length


@node
class MeasureOutline(Behavior):
    """Measure the area, perimeter and circularity of a contact; FAILURE when its border is cut, unseen or in pieces.

    Circularity is 4 pi area / perimeter^2: 1 for a disc, 0.785 for a square.
    """

    kind = "perception"
    instant = True
    contact: In[Contact]  # of a flat object
    method: In[Literal["contour", "pixel_chain", "low_pass"]] = "contour"  # how the perimeter in it is had
    circularity: Out[float]  # by that method; they differ by 10 % and more
    area: Out[Area]  # that the outline encloses
    perimeter: Out[Length]  # of the smoothed outline

    def update(self) -> Status:
        """Trace and measure."""
        outline = perception.outline_of(self.contact.labels, self.contact.surface)
        found = outline.roundness(self.method)
        self.circularity = Estimate(found.circularity, found.circularity_sd)
        self.area = Estimate(outline.area, outline.area_sd)
        self.perimeter = Estimate(outline.perimeter, outline.perimeter_sd)
        return Status.SUCCESS
