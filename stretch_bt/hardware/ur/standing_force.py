"""A controller's force that stands while its clock goes on: no sensor sends the same six numbers twice in a row for long."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.hardware.latched import NEW_RUN
from stretch_bt.hardware.ur.messages import Six

__all__ = ["STANDS_AFTER", "StandingForce"]

#: for how long, s of the controller's clock, the force may stand: as long as one that a motion goes by may be old
STANDS_AFTER = 0.2


@dataclass(frozen=True, slots=True)
class StandingForce:
    """The latest wrench, the controller's time since which it stands, and its latest time, s."""

    wrench: Six | None = None
    since: float = 0.0
    time: float = 0.0

    def take(self, time: float, wrench: Six, *, live: bool) -> StandingForce:
        """Return this with one more sample; while it is not `live`, as with the power off, a force may stand."""
        goes_on = live and wrench == self.wrench and time >= self.time
        return StandingForce(wrench, self.since if goes_on else time, time)

    def reason(self) -> str | None:
        """Return that the force stands for too long, and what to do; else None."""
        stood = self.time - self.since
        if stood <= STANDS_AFTER:
            return None
        return (
            f"the controller has sent the same force for {stood:.2g} s while its clock went on, so that no contact can be felt; "
            f"look at the pendant, switch the robot off and on, then {NEW_RUN}; of a controller that is simulated without noise, "
            "say `noisy: false` in the cell file"
        )
