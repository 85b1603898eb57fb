"""Measuring the diameter of the object in contact in several ways."""

from typing import Literal

from stretch_bt import perception
from stretch_bt.behaviors._size import Skirt, measured
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.model.calibration.sensitivity import Found
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length


@node
class CompareDiameters(Behavior):
    """Measure the widths of the object in contact in three ways from one frame; where a way refuses, its reason is kept.

    `fit` fits face and skirt jointly to the contact, with all prior knowledge of the membrane. `paper_fit` does it with the paper's
    segmentation, convex along i or along j, and no prior knowledge. `paper_width` is the width of that segmentation.
    """

    kind = "perception"
    instant = True
    frame: In[DepthFrame]  # frame with the hand's stretch
    hypothesis: In[Literal["auto", "circle", "ellipse"]] = "auto"  # shape that `fit` fits
    skirt: In[Skirt] = "thick"  # skirt of a sheet that does not resist bending, or of one that does
    mount_prestretch: In[Length] = port(
        0.0, min=0.0, max=0.05, doc="prestretch of the membrane by its mounts, at stretch 0"
    )
    found: Out[tuple[Found, ...]]  # the widths by each way, in this order

    def update(self) -> Status:
        """Measure."""
        ours, why = self._contact("mean")
        theirs, why_not = self._contact("either")
        self.found = (
            self._told("fit", ours, why),
            self._told("paper_fit", theirs, why_not),
            self._told("paper_width", theirs, why_not),
        )
        return Status.SUCCESS

    def _contact(self, rule: Literal["mean", "either"]) -> tuple[Contact | None, str]:
        try:
            return perception.find_contact(self.frame, rule=rule), ""
        except NoAnswer as error:
            return None, str(error)

    def _told(self, method: str, contact: Contact | None, why: str) -> Found:
        if contact is None:
            return Found(method, refused=why)
        try:
            return self._measured(method, contact)
        except NoAnswer as error:
            return Found(method, refused=str(error))

    def _measured(self, method: str, contact: Contact) -> Found:
        if method == "paper_width":
            width = perception.contact_width(contact.surface, contact.labels)
            return Found(method, width.i, width.i_sd, width.j, width.j_sd)
        if method == "paper_fit":
            size = perception.measure_contact(contact.surface, contact.labels)
        else:
            size = measured(
                contact, hypothesis=self.hypothesis, skirt=self.skirt, mount_prestretch=self.mount_prestretch
            )
        return Found(method, size.diameter_i, size.diameter_i_sd, size.diameter_j, size.diameter_j_sd, size.shape)
