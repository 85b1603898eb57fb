"""How far the highest part of the membrane stands out."""

import math

import numpy as np

from stretch_bt import Behavior, In, Out, Status, node, port
from stretch_bt.errors import NoContact
from stretch_bt.perception import Contact
from stretch_bt.units import Estimate, Length


@node
class CrownHeight(Behavior):
    """Average the highest part of the membrane; FAILURE when none of it is seen."""

    kind = "perception"
    instant = True
    contact: In[Contact]  # its surface and noise are read
    share: In[float] = port(0.01, min=0.0, max=1.0, doc="of the pixels, the highest, that is averaged")
    crown: Out[Length]  # height above the plane of the undeformed membrane

    def update(self) -> Status:
        """Average."""
        heights = self.contact.surface[..., 2]
        seen = np.sort(heights[np.isfinite(heights)])
        if not seen.size:
            raise NoContact("no pixel of the membrane is seen")
        top = seen[-math.ceil(self.share * seen.size) or -1 :]
        alike = min(self.contact.noise_area, top.size)  # pixels that share their noise
        self.crown = Estimate(float(top.mean()), self.contact.noise * math.sqrt(alike / top.size))
        return Status.SUCCESS
