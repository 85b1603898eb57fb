"""How much force is lost between two presses."""

import math

from stretch_bt import Behavior, In, Out, Status, node, port
from stretch_bt.errors import IllConditioned
from stretch_bt.units import Estimate, Force


@node
class ForceLoss(Behavior):
    """Compute which part of the first force is gone at the second; FAILURE when the first is within its error of zero."""

    kind = "model"
    instant = True
    first: In[Force] = port(min=0.0, doc="at the first press")
    second: In[Force] = port(min=0.0, doc="at the second press")
    force_sd: In[Force] = port(0.05, min=0.0, doc="standard deviation of each force")
    loss: Out[float]  # between 0 and 1; below 0 when the second force is the greater

    def update(self) -> Status:
        """Divide, with the standard deviation that both forces give it."""
        first, second, sd = self.first, self.second, self.force_sd
        if first <= 3 * sd:
            raise IllConditioned(f"a first force of {first:.3g} N is within three standard deviations of zero")
        ratio = second / first
        self.loss = Estimate(1 - ratio, sd / first * math.hypot(1, ratio))
        return Status.SUCCESS
