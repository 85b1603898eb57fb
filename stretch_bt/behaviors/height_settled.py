"""Deciding whether the height of a rolling lump has settled."""

from stretch_bt.behaviors._spread import spread_of
from stretch_bt.behaviors.records import Heights
from stretch_bt.tree.ports import Behavior, In, InOut, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length

UNKNOWN = 0.1  # m, spread before there are two heights: no limit is larger


@node
class HeightSettled(Behavior):
    """Take one more height, and decide whether the last ones spread by less than a limit.

    Equal heights in all positions are no proof that a lump is round: a path that repeats one rotation meets the
    same places again, and heights are blind to shapes of constant width.
    """

    kind = "perception"
    instant = True
    height: In[Length]  # latest height
    height_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of height, which is not taken off the spread")
    count: In[int] = port(10, min=3, max=1000, doc="number of last heights that count")
    limit: In[Length] = port(0.001, min=1e-6, max=0.1, doc="limit of their standard deviation")
    reset: In[bool] = False  # whether to begin anew with this height
    heights: InOut[Heights | None]  # last heights
    spread: Out[Length]  # standard deviation of the last heights, as many as there are; 100 mm before two
    settled: Out[bool]  # whether there are enough of them and their spread is under the limit

    def update(self) -> Status:
        """Take it, and look at the last ones."""
        before = () if self.reset or self.heights is None else self.heights.values
        known = (*before, float(self.height))[-self.count :]
        self.heights = Heights(known)
        spread = spread_of(known, self.height_sd)
        self.spread = spread = Estimate(UNKNOWN, UNKNOWN) if spread is None else spread
        self.settled = len(known) >= self.count and spread.value < self.limit
        return Status.SUCCESS
