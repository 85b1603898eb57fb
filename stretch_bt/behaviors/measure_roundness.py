"""How round a lump is, from looks at it between which it turned."""

import math
import statistics

from stretch_bt import perception
from stretch_bt.behaviors._spread import spread_of
from stretch_bt.behaviors.records import LumpLook, LumpLooks
from stretch_bt.errors import NoAnswer
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, InOut, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length

UNKNOWN = 1.0  # residual and spread over the radius, and standard deviation of the width, before there are two looks


@node
class MeasureRoundness(Behavior):
    """Take one more look at a lump that rolls, and compare the last ones with a ball.

    Looks between which the lump turned give three quantities: the residual of its caps from their mean, the mean circularity of their level
    lines, and its mean height over the diameter of the ball of its volume. Of all bodies of a volume
    the ball has the least mean width (Urysohn 1924), so that the mean height, unlike the spread of the heights, misses no shape; the
    load of the hand lowers it. A level line that is cut or unseen is left out;
    under a tense membrane level lines show more of the membrane than of the lump.
    """

    kind = "perception"
    instant = True
    contact: In[Contact]  # latest contact
    height: In[Length]  # height of the top over the table, at the same look
    height_sd: In[Length] = port(
        0.0, min=0.0, doc="standard deviation of height, of which all looks may share any part"
    )
    radius: In[Length] = port(min=0.001, max=0.1, doc="radius of the ball of the lump's volume")
    count: In[int] = port(6, min=2, max=1000, doc="number of last looks that count")
    level: In[Length | None] = port(None, min=0.0005, max=0.02, doc="depth of the level lines below the top, if any")
    lump_looks: InOut[LumpLooks | None]  # last looks
    residual: Out[float]  # caps' residual from their mean over the radius, less the camera's noise; 1 before two looks
    spread: Out[float]  # standard deviation of the heights over the radius; 1 before two looks
    width: Out[float]  # mean height over the diameter
    outline: Out[float]  # mean circularity of the level lines, low-pass; 0 where none was drawn

    def update(self) -> Status:
        """Look, and take the last looks together."""
        look = LumpLook(
            perception.cap_of(self.contact, self.radius), float(self.height), self._outline(), self.height_sd
        )
        before = () if self.lump_looks is None else self.lump_looks.looks
        looks = (*before, look)[-self.count :]
        self.lump_looks = LumpLooks(looks)
        self.residual = _residual(looks, self.radius)
        self.spread, self.width = _spread(looks, self.radius), _width(looks, self.radius)
        self.outline = statistics.fmean([look.outline for look in looks if look.outline is not None] or [0.0])
        return Status.SUCCESS

    def _outline(self) -> float | None:
        if self.level is None:
            return None
        try:
            return perception.outline_at(self.contact.surface, self.level).roundness("low_pass").circularity
        except NoAnswer:
            return None


def _residual(looks: tuple[LumpLook, ...], radius: Length) -> Estimate:
    if len(looks) < 2:
        return Estimate(UNKNOWN, UNKNOWN)
    found = perception.cap_residual([look.cap for look in looks])
    return Estimate(found.value / radius, found.sd / radius)


def _spread(looks: tuple[LumpLook, ...], radius: Length) -> Estimate:
    found = spread_of([look.height for look in looks], _shared(looks))
    return Estimate(UNKNOWN, UNKNOWN) if found is None else Estimate(found.value / radius, found.sd / radius)


def _width(looks: tuple[LumpLook, ...], radius: Length) -> Estimate:
    """Return the mean height over the diameter; how much of the heights' errors all looks share is unknown, so that none is averaged out."""
    mean = statistics.fmean(look.height for look in looks) / (2 * radius)
    if len(looks) < 2:
        return Estimate(mean, UNKNOWN)
    scatter = statistics.stdev(look.height for look in looks) / math.sqrt(len(looks))
    return Estimate(mean, math.hypot(scatter, _shared(looks)) / (2 * radius))


def _shared(looks: tuple[LumpLook, ...]) -> Length:
    return statistics.fmean(look.height_sd for look in looks)
