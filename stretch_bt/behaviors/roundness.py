"""How round a lump is, from what several ways it lay show of it."""

import statistics
from typing import NamedTuple

from stretch_bt import perception
from stretch_bt.errors import NoAnswer
from stretch_bt.perception.cap import Cap
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length

UNKNOWN = 1.0  # residual over the radius before there are two looks


class _Look(NamedTuple):
    cap: Cap
    height: float
    outline: float | None


@node
class Roundness(Behavior):
    """Take one more look at a lump that rolls, and tell from the last ones how far it is from a ball.

    Of looks between which the lump turned three things are told: by how much its caps differ from their mean, how round their level
    lines are on average, and how high it is on average over the diameter of the ball of its volume. Of all bodies of a volume
    the ball has the least mean width (Urysohn 1924), so that the last, unlike the spread of the heights, misses no shape; the
    load of the hand lowers it. Level lines are drawn where `min_outline` is above 0; one that is cut or unseen is left out, and
    under a tense membrane they say more of the membrane than of the lump.
    """

    kind = "perception"
    instant = True
    contact: In[Contact]  # the latest
    height: In[Length]  # of the top over the table, at the same look
    radius: In[Length] = port(min=0.001, max=0.1, doc="of the ball of the lump's volume")
    count: In[int] = port(6, min=2, max=1000, doc="how many of the last looks count")
    max_residual: In[float] = port(0.02, min=0.0, max=1.0, doc="of the caps, over the radius")
    max_spread: In[float] = port(0.08, min=0.0, max=1.0, doc="of the heights, over the radius")
    max_width: In[float] = port(1.02, min=0.5, max=2.0, doc="mean height, over the diameter")
    min_outline: In[float] = port(0.0, min=0.0, max=1.0, doc="circularity of the level lines, on average")
    level: In[Length] = port(0.003, min=0.0005, max=0.02, doc="of the lines, below the top")
    reset: In[bool] = False  # whether to begin anew with this look
    residual: Out[float]  # of the caps from their mean over the radius, without the camera's noise; 1 before two looks
    spread: Out[float]  # standard deviation of the heights over the radius
    width: Out[float]  # mean height over the diameter
    outline: Out[float]  # mean circularity of the level lines, low-pass; 0 where none was drawn
    round: Out[bool]  # whether there are enough looks and all four are within their limits

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self.looks: list[_Look] = []

    def update(self) -> Status:
        """Look, and take the last looks together."""
        look = _Look(
            perception.cap_of(self.contact, self.radius),
            float(self.height),
            self._outline() if self.min_outline > 0 else None,
        )
        self.looks = [*([] if self.reset else self.looks), look][-self.count :]
        radius, number = self.radius, len(self.looks)
        heights = [look.height / radius for look in self.looks]
        lines = [look.outline for look in self.looks if look.outline is not None]
        residual = self._residual(radius)
        spread, width, outline = (
            statistics.pstdev(heights),
            statistics.fmean(heights) / 2,
            statistics.fmean(lines or [0.0]),
        )
        self.residual = residual
        self.spread = Estimate(spread, spread / (2 * number) ** 0.5)
        self.width = Estimate(width, spread / 2 / number**0.5)
        self.outline = outline
        within = residual.value <= self.max_residual and spread <= self.max_spread
        self.round = number >= self.count and within and width <= self.max_width and outline >= self.min_outline
        return Status.SUCCESS

    def _residual(self, radius: float) -> Estimate:
        if len(self.looks) < 2:
            return Estimate(UNKNOWN, UNKNOWN)
        found = perception.cap_residual([look.cap for look in self.looks])
        return Estimate(found.value / radius, found.sd / radius)

    def _outline(self) -> float | None:
        try:
            return perception.outline_at(self.contact.surface, self.level).roundness("low_pass").circularity
        except NoAnswer:
            return None
