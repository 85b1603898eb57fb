"""Waiting."""

from stretch_bt.tree.countdown import Countdown
from stretch_bt.tree.ports import Behavior, In, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Time


@node
class Wait(Behavior):
    """Let some time pass."""

    kind = "condition"
    duration: In[Time] = port(min=0.0, doc="duration by the run's clock")

    def initialise(self) -> None:
        """Start the time."""
        self.time = Countdown(self.context, self.duration)

    def update(self) -> Status:
        """Wait."""
        return Status.SUCCESS if self.time.over else Status.RUNNING
