"""How round a lump is, from what several ways it lay show of it."""

import math
import statistics

from stretch_bt import perception
from stretch_bt.errors import NoAnswer
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length


@node
class Roundness(Behavior):
    """Take one more look at a lump that rolls, and tell from the last ones how far it is from a ball.

    Each look gives how far the cap in contact is from a sphere, the circularity of the contact's outline, and the height. A single
    look sees a part of the lump; what is told is the root mean square of the residuals, the mean of the outlines and the spread of
    the heights over looks that the lump turned between. An outline that is cut or unseen is left out.
    """

    kind = "perception"
    instant = True
    contact: In[Contact]  # the latest
    height: In[Length]  # of the top, at the same look
    count: In[int] = port(6, min=1, max=1000, doc="how many of the last looks count")
    max_residual: In[Length] = port(0.0004, min=1e-6, max=0.1, doc="of the caps from their spheres")
    max_spread: In[Length] = port(0.0012, min=1e-6, max=0.1, doc="of the heights")
    min_outline: In[float] = port(0.0, min=0.0, max=1.0, doc="circularity of the outlines of contact, on average")
    reset: In[bool] = False  # whether to begin anew with this look
    residual: Out[Length]  # of the caps from their spheres, without the camera's noise
    spread: Out[Length]  # standard deviation of the heights
    outline: Out[float]  # mean circularity of the contacts' outlines, 0 where none could be had
    round: Out[bool]  # whether there are enough looks and all three are within their limits

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self.looks: list[tuple[Estimate, float, float | None]] = []

    def update(self) -> Status:
        """Look, and take the last looks together."""
        residual = perception.cap_residual(self.contact)
        look = (residual, float(self.height), self._outline())
        self.looks = [*([] if self.reset else self.looks), look][-self.count :]
        number = len(self.looks)
        residuals = [look[0] for look in self.looks]
        mean = math.sqrt(statistics.fmean(r.value**2 for r in residuals))
        sd = math.sqrt(sum((r.value * r.sd) ** 2 for r in residuals)) / (number * mean) if mean > 0 else residual.sd
        spread = statistics.pstdev([look[1] for look in self.looks])
        outlines = [line for _, _, line in self.looks if line is not None]
        outline = statistics.fmean(outlines) if outlines else 0.0
        self.residual = Estimate(mean, sd)
        self.spread = Estimate(spread, spread / math.sqrt(2 * number))
        self.outline = outline
        within = mean < self.max_residual and spread < self.max_spread and outline >= self.min_outline
        self.round = number >= self.count and within
        return Status.SUCCESS

    def _outline(self) -> float | None:
        try:
            found = perception.outline_of(self.contact.labels, self.contact.surface).roundness("low_pass")
        except NoAnswer:
            return None
        return found.circularity
