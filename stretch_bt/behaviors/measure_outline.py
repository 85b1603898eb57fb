"""Measuring the outline of a flat object."""

from typing import Literal

from stretch_bt import perception
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.registry import node
from stretch_bt.units import Area, Estimate, Length


@node
class MeasureOutline(Behavior):
    """Measure the area, perimeter and circularity of a contact; FAILURE where its border is cut, in pieces, or beside pixels without depth.

    Circularity is 4 pi area / perimeter^2: 1 for a disc, 0.785 for a square. The deviations include an error of the
    whole border, outward or inward: 2.2 mm where curvature does not show it, and 8 mm under a membrane whose stretch is unknown or
    less than 5 mm. With a `level` the outline is the membrane's level line that far below its highest place, which flat and low
    objects show better than the curvature that shows contact.
    """

    kind = "perception"
    instant = True
    contact: In[Contact]  # contact of a flat object
    level: In[Length | None] = None  # distance below the highest place; without it the border of the contact is taken
    method: In[Literal["contour", "pixel_chain", "low_pass"]] = "contour"  # method for the perimeter in circularity
    circularity: Out[float]  # circularity by that method; the methods differ by 10 % and more
    area: Out[Area]  # area that the outline encloses
    line: Out[list[float]]  # x and y of the outline's corners in turn, m, membrane frame
    perimeter: Out[Length]  # length of the smoothed outline

    def update(self) -> Status:
        """Trace and measure."""
        outline = self._line(self.contact, self.level)
        found = outline.roundness(self.method)
        self.circularity = Estimate(found.circularity, found.circularity_sd)
        self.area = Estimate(outline.area, outline.area_sd)
        self.line = [round(float(v), 6) for v in outline.vertices.reshape(-1)]
        self.perimeter = Estimate(outline.perimeter, outline.perimeter_sd)
        return Status.SUCCESS

    def _line(self, contact: Contact, level: float | None) -> perception.Outline:
        if level is not None:
            return perception.outline_at(contact.surface, level, noise=contact.surface_noise)
        return perception.contact_outline(contact)
